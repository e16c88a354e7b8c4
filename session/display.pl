:- module(session_display,
          [ show/2,                     % +Options, +Message
            tell/3                      % +Options, +Action, +Situation
          ]).
:- use_module('../domain/reasoning/candidates').
:- use_module('../domain/reasoning/device').
:- use_module('../domain/reasoning/image_set').
:- use_module('../domain/reasoning/merit').
:- use_module('../domain/reasoning/qualitative').
:- use_module('../indigolog/indigolog', [fluent_value/3]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(library(option), [option/2]).

/** <module> What a person sees of a session in the terminal

All text of a session, as messages: session(Term).
*/

%!  show(+Options, +Message) is det.
%
%   Live lines go to standard error, which leaves standard output to --json.

show(Options, _) :-
    option(quiet(true), Options),
    !.
show(_, Message) :-
    print_message(help, session(Message)).

%!  tell(+Options, +Action, +Situation) is det.
%
%   What is to be seen of an action that led to Situation.

tell(Options, Action, Situation) :-
    forall(told(Options, Action, Situation, Message), show(Options, Message)).

told(_, Action, Situation, Message) :-
    shown(Action, Situation, Message).
told(Options, Action, Situation, Message) :-
    option(explain(true), Options),
    explained(Action, Situation, Message).

shown(connect, Situation, connected(Device)) :-
    fluent_value(device, Situation, Device).
shown(keep(_), Situation, step(Device, Step)) :-
    last_step(Situation, Device, Step).
shown(discard(_, _), Situation, step(Device, Step)) :-
    last_step(Situation, Device, Step).
shown(advance(Range), _, hold(Range)).
shown(hold_done(Outcome), _, hold_done(Outcome)).
shown(Event, _, event(Event)) :-
    memberchk(Event, [light_fault(_), camera_fault, sun_changed]).

%   What --explain adds: why these settings, what the image shows, what it changed.
explained(choose(Settings), Situation, chosen(Device, Settings, Why)) :-
    fluent_value(device, Situation, Device),
    fluent_value(readings, Situation, Readings),
    fluent_value(image_set, Situation, ImageSet),
    fluent_value(unfavourable, Situation, Unfavourable),
    kept_states(ImageSet, Kept),
    ranking(Device, experience(Readings, Kept, Unfavourable), Ranked),
    memberchk(ranked(_, Settings, Why), Ranked).
explained(capture(_, _), Situation, seen(Statistics, Quality)) :-
    fluent_value(statistics, Situation, Statistics),
    image_quality(Statistics, Quality).
explained(estimate(_), Situation, measured(Fix, New, Old)) :-
    fluent_value(fix, Situation, Fix),
    fluent_value(merit, Situation, Old),
    merit(Fix, New).

last_step(Situation, Device, Step) :-
    fluent_value(device, Situation, Device),
    fluent_value(steps, Situation, [Step|_]).

:- multifile prolog:message//1, prolog:error_message//1.

prolog:message(session(Term)) -->
    session_message(Term).

session_message(begin(Plan, Folder)) -->
    [ 'Session: ', ansi(bold, '~w', [Plan.controller]), ' on ', ansi(bold, '~w', [Plan.target]),
      ', seed ~w'-[Plan.seed], nl, '  run folder ~w'-[Folder] ].
session_message(connected(Device)) -->
    { device_lights(Device, Lights), length(Lights, Count),
      device_shutters(Device, Shutters), length(Shutters, ShutterCount),
      device_apertures(Device, Apertures), length(Apertures, ApertureCount) },
    [ '  ~d lights, ~d shutters, ~d apertures'-[Count, ShutterCount, ApertureCount] ].
session_message(step(Device, step(_, Image, Settings, State, Decision, Reason, SetSize, Fix, _))) -->
    { settings_words(Device, Settings, Words),
      state_words(State, StateWords),
      merit(Fix, Merit) },
    [ '  ~w~t~7|~w~t~48|~w~t~77|'-[Image, Words, StateWords] ],
    decision(Decision),
    fix_words(Fix, Merit),
    [ '  set ~d'-[SetSize] ],
    reason(Reason).
session_message(would_do(Plan)) -->
    [ 'Would run the controller ', ansi(bold, '~w', [Plan.controller]), ' (~w)'-[Plan.controller_file], nl,
      '  on target ~w, seed ~w'-[Plan.target, Plan.seed], nl,
      '  program ~w'-[Plan.program], nl,
      '  theory and controller load without complaint; nothing was started'-[] ].
session_message(hold_done(fixed)) -->
    [ ansi(fg(green), '  pose fixed: go on', []) ].
session_message(hold_done(reached)) -->
    [ ansi([bold, fg(green)], '  contact range reached with a trusted pose', []) ].
session_message(hold_done(aborted)) -->
    [ ansi([bold, fg(red)], '  approach aborted: no pose to be trusted here', []) ].
session_message(no_report(Status)) -->
    [ 'report.html was not written (~w); try: .venv/bin/python -m report RUN_FOLDER'-[Status] ].
session_message(hold(Range)) -->
    [ 'Hold point at ~w m'-[Range] ].
session_message(event(Action)) -->
    [ ansi(fg(yellow), '  event: ~w', [Action]) ].
session_message(outcome(converged, Result)) -->
    [ ansi([bold, fg(green)], 'Pose found', []) ],
    outcome(Result).
session_message(outcome(exhausted, Result)) -->
    [ ansi([bold, fg(yellow)], 'Not trusted: the threshold was not reached', []) ],
    outcome(Result).
session_message(outcome(stopped, Result)) -->
    [ ansi([bold, fg(red)], 'Stopped', []) ],
    outcome(Result).
session_message(limit(Limit)) -->
    [ ansi(fg(yellow), '  the strategy ends by --max-iterations ~d, not by itself', [Limit]) ].
session_message(report(File)) -->
    [ '  report ~w'-[File] ].
session_message(chosen(Device, Settings, why(_, Promise, prediction(Brightness, Highlight, Blur, _)))) -->
    { settings_words(Device, Settings, Words),
      Median is 100 * Brightness,
      High is 100 * Highlight },
    [ ansi(fg(cyan), '       chose ~w: expects median ~0f %, highlights ~0f %, edges ~1f px wide; promise ~2f',
           [Words, Median, High, Blur, Promise]) ].
session_message(seen(statistics(P50, P95, Dark, Saturated, _), Quality)) -->
    { Numbers = [P50, P95, Dark, Saturated], maplist(percent, Numbers, Percents) },
    [ ansi(fg(cyan), '       saw a ~w image: median ~0f %, highlights ~0f %, dark ~0f %, saturated ~0f %',
           [Quality|Percents]) ].
session_message(measured(fix(_, _, quality(Rms, Uncertainty, Support, Score, Ambiguity), _), New, Old)) -->
    { Permille is 1000 * Uncertainty, Percent is 100 * Support },
    [ ansi(fg(cyan), '       rms ~2f px, uncertainty ~2f permille, ~0f % of the lines found, score ~2f, ambiguity ~2f; ',
           [Rms, Permille, Percent, Score, Ambiguity]),
      ansi(fg(cyan), 'merit ~2f (was ~2f)', [New, Old]) ].
session_message(measured(none, _, _)) -->
    [ ansi(fg(cyan), '       no pose in these images', []) ].

decision(keep) -->
    [ ansi(fg(green), 'keep   ', []) ].
decision(discard) -->
    [ ansi(fg(red), 'discard', []) ].

fix_words(none, _) -->
    [ '  no pose                ' ].
fix_words(Fix, Merit) -->
    { fix_rms(Fix, Rms) },
    [ '  rms ~2f px  merit ~2f'-[Rms, Merit] ].

reason('') -->
    [].
reason(Reason) -->
    { Reason \== '' },
    [ '  (~w)'-[Reason] ].

outcome(Result) -->
    { length(Result.kept, Kept) },
    [ ' after ~d images, ~d kept, ~1f s'-[Result.iterations, Kept, Result.seconds.total] ],
    pose_words(Result),
    error_words(Result).

pose_words(Result) -->
    { is_dict(Result.pose) },
    !,
    { Result.pose.translation = [X, Y, Z],
      Result.pose.rotation_vector = [A, B, C] },
    [ nl, '  translation ~4f ~4f ~4f m'-[X, Y, Z], nl,
      '  rotation    ~4f ~4f ~4f rad'-[A, B, C], nl,
      '  rms ~2f px, merit ~2f px (threshold ~2f)'-[Result.rms_px, Result.merit_px, Result.threshold_px] ].
pose_words(_) -->
    [ nl, '  no pose' ].

error_words(Result) -->
    { Error = Result.get(error) },
    !,
    { Percent is 100 * Error.translation_fraction_of_range,
      Millimetres is 1000 * Error.translation_m },
    [ nl, '  true error ~3f deg, ~2f mm (~3f % of range)'-[Error.rotation_deg, Millimetres, Percent] ].
error_words(_) -->
    [].

prolog:error_message(usage_error(Message)) -->
    [ '~s'-[Message] ].
prolog:error_message(server_died(Name, Status, Line, LogFile)) -->
    [ 'the ~w ended by itself (~w)'-[Name, Status] ],
    last_words(Line),
    [ nl, '  its log is ~w'-[LogFile] ].

last_words("") -->
    [].
last_words(Line) -->
    { Line \== "" },
    [ ': ~w'-[Line] ].

percent(Fraction, Percent) :-
    Percent is 100 * Fraction.
