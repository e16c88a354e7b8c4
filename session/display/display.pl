:- module(session_display,
          [ show/2,                     % +Options, +Message
            show_address/0,
            show_outcome/2,             % +Options, +Result
            tell/3                      % +Options, +Action, +Situation
          ]).
/** <module> What a person sees of a session in the terminal

All text of a session, as messages: session(Term).
*/

:- use_module(explanation, [explanation//2]).
:- use_module(live_table, [note_action/2, table_head//1, table_is_live/0, table_row//2]).
:- use_module(outcome, [counted/3, merit_words/2]).
:- use_module(reasons, [decision_reason/3]).
:- use_module('../folder/result', [print_result/1]).
:- use_module('../shell_words', [shell_word/2]).
:- use_module(server_words, [server_words/2, what_happened/2, what_is_done/2]).
:- use_module(viewing, [view_address/1]).
:- use_module(wrapping, [wrapped/3]).
:- use_module('../../domain/reasoning/device').
:- use_module('../../domain/reasoning/surprises', [cause_words/2]).
:- use_module('../../domain/reasoning/merit').
:- use_module('../../domain/reasoning/qualitative').
:- use_module('../../indigolog/indigolog', [fluent_value/3]).
:- use_module(library(apply), [maplist/3, maplist/4]).
:- use_module(library(lists), [memberchk/2]).
:- use_module(library(option), [option/2]).

%!  show(+Options, +Message) is det.
%
%   Live lines go to standard error.

show(Options, _) :-
    option(quiet(true), Options),
    !.
show(_, Message) :-
    print_message(help, session(Message)).

%!  show_address is det.
%
%   Where the session can be watched, as soon as its view has said so, however quiet the session is to be.

show_address :-
    forall(view_address(Line), print_message(help, session(view(Line)))).

%!  show_outcome(+Options, +Result) is det.
%
%   The result goes to standard output, however quiet a session is to be; with --json that is what is printed there.

show_outcome(Options, Result) :-
    option(json(true), Options),
    !,
    (   option(quiet(true), Options)
    ->  true
    ;   outcome_lines(user_error, Result)
    ),
    catch(print_result(Result), error(io_error(write, _), _), true).
show_outcome(_, Result) :-
    outcome_lines(user_output, Result).

outcome_lines(Stream, Result) :-
    phrase(prolog:message(session_outcome(Result)), Lines),
    wrapped(Stream, Lines, Wrapped),
    catch(print_message_lines(Stream, '', Wrapped), error(io_error(write, _), _), true).       % nobody reads on

%!  tell(+Options, +Action, +Situation) is det.
%
%   What is to be seen of an action that led to Situation.

tell(Options, Action, Situation) :-
    note_action(Action, Situation),
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
    memberchk(Event, [light_fault(_), camera_fault, sun_changed, target_moved, surprise(_, _), doubt(_, _)]).

%   What --explain adds: why these settings, what the image shows, what it changed.
explained(Action, Situation, because(Device, Reason)) :-
    decision_reason(Action, Situation, Reason),
    fluent_value(device, Situation, Device).

last_step(Situation, Device, Step) :-
    fluent_value(device, Situation, Device),
    fluent_value(steps, Situation, [Step|_]).

:- multifile prolog:message//1.

prolog:message(session(Term)) -->
    session_message(Term).

session_message(begin(Plan, Folder)) -->
    [ 'Session: ', ansi(bold, '~w', [Plan.controller]) ],
    on_what(Plan.shows),
    [ ', seed ~w'-[Plan.seed], nl, '  run folder ~w'-[Folder] ],
    planned(Plan.program).
session_message(model(Model)) -->
    model_size(Model),
    model_doubt(Model).
session_message(connected(Device)) -->
    { device_words(Device, Words) },
    [ '  ~w'-[Words] ],
    head(Device).
session_message(unknown_places(Lights)) -->
    { most_named(Most), length(Lights, Count),
      ( Count =< Most -> atomic_list_concat(Lights, ', ', Names) ; counted(Count, light, Names) ) },
    [ '  `position` of ~w is not told: such a light is expected to light all faces alike, until images tell'-[Names] ].
session_message(step(Device, Step)) -->
    { table_is_live },
    !,
    table_row(Device, Step).
session_message(step(Device, step(_, Image, Settings, State, Decision, Reason, SetSize, Fix, _))) -->
    { brief_settings_words(Device, Settings, Words),
      state_words(State, StateWords),
      merit(Fix, Merit) },
    [ '  ~w~t ~7|~w~t ~48|~w~t ~77|'-[Image, Words, StateWords] ],
    decision(Decision),
    fix_words(Fix, Merit),
    [ '  set ~d'-[SetSize] ],
    reason(Reason).
session_message(would_do(Plan, Device)) -->
    { device_words(Device, Words) },
    [ 'Would run the controller ', ansi(bold, '~w', [Plan.controller]), ' (~w)'-[Plan.controller_file], nl,
      '  on target ~w, seed ~w'-[Plan.target, Plan.seed], nl,
      '  program ~w'-[Plan.program], nl,
      '  on ~w'-[Words], nl,
      '  theory and controller load without complaint, and the servers took what they were told; no image was taken' ].
session_message(waiting(_, start)) -->  % the vision server waits for the image server, too
    !,
    [ '  waiting for the servers to start ...' ].
session_message(waiting(Name, Op)) -->
    { server_words(Name, Words) },
    [ '  waiting for the ~w to answer "~w" ...'-[Words, Op] ].
session_message(view(Line)) -->
    [ '~w'-[Line] ].
session_message(brought_back(Error, Times, Most)) -->
    { what_happened(Error, What),
      what_is_done(Error, Done)
    },
    [ ansi(fg(yellow), '  ~w: ~w, and the session goes on (~d of at most ~d times)', [What, Done, Times, Most]) ].
session_message(thinking(now, wait)) -->
    [ '  the strategy waits for an event ...' ].
session_message(thinking(now, computing(Place, Where))) -->
    [ '  the strategy computes~w (~w) ...'-[Where, Place] ].
session_message(thinking(stopped, wait)) -->
    [ '  stopped while the strategy waited for an event' ].
session_message(thinking(stopped, computing(Place, Where))) -->
    [ '  stopped while the strategy computed~w (~w)'-[Where, Place] ].
session_message(missed(Name, Endpoint, Seconds)) -->
    { server_words(Name, Words) },
    [ ansi(fg(yellow), '  nobody listens at ~w any more: the ~w is waited for, for ~d s', [Endpoint, Words, Seconds]) ].
session_message(hold_done(fixed)) -->
    [ ansi(fg(green), '  pose fixed: go on', []) ].
session_message(hold_done(reached)) -->
    [ ansi([bold, fg(green)], '  contact range reached with a trusted pose', []) ].
session_message(hold_done(aborted)) -->
    [ ansi([bold, fg(red)], '  approach aborted: no pose to be trusted here', []) ].
session_message(no_report(Folder, Status)) -->
    { shell_word(Folder, Word) },
    [ 'report.html was not written (~w); try: .venv/bin/python -m report ~w'-[Status, Word] ].
session_message(farther(Program)) -->
    [ '  the target is too large for these:' ], planned(Program).
session_message(hold(Range)) -->
    [ 'Hold point at ~w m'-[Range] ].
session_message(others_applied(Image, Applied)) -->
    { atomic_list_concat(Applied.lights, ' ', Levels) },
    [ ansi(fg(yellow), '  ~w was taken under other settings than were asked for, and so may others: ', [Image]),
      ansi(fg(yellow), 'light levels ~w, ~4g s, f/~w', [Levels, Applied.shutter_s, Applied.aperture]) ].
session_message(event(surprise(_, model_wrong(Axis, Share)))) -->
    !,
    { cause_words(model_wrong(Axis, Share), Words) },
    [ ansi(fg(yellow), '  ~w', [Words]) ].
session_message(event(surprise(Image, Cause))) -->
    !,
    { cause_words(Cause, Words) },
    [ ansi(fg(yellow), '  ~w is not as foreseen: ~w', [Image, Words]) ].
session_message(event(doubt(Image, Cause))) -->
    !,
    { cause_words(Cause, Words) },
    [ ansi(fg(yellow), '  ~w is not as foreseen, perhaps: ~w', [Image, Words]) ].
session_message(event(Action)) -->
    [ ansi(fg(yellow), '  event: ~w', [Action]) ].
session_message(limit(Limit)) -->
    [ ansi(fg(yellow), '  the strategy ends by --max-iterations ~d, not by itself', [Limit]) ].
session_message(ended_before(Number)) -->
    [ '--instead: the session ended before i~d'-[Number] ].
session_message(report(File)) -->
    [ '  report ~w'-[File] ].
session_message(no_further(Whys)) -->
    [ '  why the strategy went no further:', nl ],
    prolog:message(golog(why(Whys))).
session_message(goes_on(By, Folder)) -->
    { interruption_words(By, Words), shell_word(Folder, Word) },
    [ '  ~w--resume ~w goes on'-[Words, Word] ].
session_message(because(Device, Reason)) -->
    explanation(Device, Reason).

interruption_words(ctrl_c, 'stopped by Ctrl-C: ').
interruption_words(other, 'stopped by SIGTERM, or in its view: ').
interruption_words(failure, '').

most_named(6).                          % lights in a line; chosen by hand

%   The model line says what an image server shows, when that has told.
on_what(target(Name)) -->
    [ ' on ', ansi(bold, '~w', [Name]) ].
on_what(stack(Dir)) -->
    [ ' on the stack ', ansi(bold, '~w', [Dir]) ].
on_what(served) -->
    [].

head(Device) -->
    { table_is_live },
    !,
    [ nl ],
    table_head(Device).
head(_) -->
    [].

planned(session(Ranges)) -->
    !,
    { atomic_list_concat(Ranges, ', ', Words) },
    [ nl, '  hold points at ~w m'-[Words] ].
planned(_) -->
    [].

%   A wrong unit shows in the size.
model_size(Model) -->
    { _{name:Name, diameter_m:Diameter, picture_px:Pixels} :< Model, number(Diameter), number(Pixels) },
    !,
    [ '  model ~w: ~3g m across, ~0f px in the image from the seed pose'-[Name, Diameter, Pixels] ].
model_size(Model) -->
    { _{name:Name, diameter_m:Diameter} :< Model, number(Diameter) },
    !,
    [ '  model ~w: ~3g m across, looked for everywhere (no seed pose)'-[Name, Diameter] ].
model_size(Model) -->
    [ '  model ~w'-[Model.name] ].

model_doubt(Model) -->
    { string(Model.get(doubt)) },
    !,
    [ nl, ansi(fg(yellow), '  can that be? ~w', [Model.doubt]) ].
model_doubt(_) -->
    [].

device_words(Device, Words) :-
    device_lights(Device, Lights),
    device_shutters(Device, Shutters),
    device_apertures(Device, Apertures),
    maplist(length, [Lights, Shutters, Apertures], Lengths),
    maplist(counted, Lengths, [light, shutter, aperture], Counts),
    atomic_list_concat(Counts, ', ', Words).

decision(keep) -->
    [ ansi(fg(green), 'keep   ', []) ].
decision(discard) -->
    [ ansi(fg(red), 'discard', []) ].

fix_words(none, _) -->
    [ '  no pose                ' ].
fix_words(Fix, Merit) -->
    { fix_rms(Fix, Rms), merit_words(Merit, Words) },
    [ '  rms ~2f px  merit ~w'-[Rms, Words] ].

reason('') -->
    [].
reason(Reason) -->
    { Reason \== '' },
    [ '  (~w)'-[Reason] ].
