:- module(display, []).
:- use_module('../domain/device').
:- use_module('../domain/merit').
:- use_module('../domain/qualitative').

/** <module> What a person sees of a session in the terminal

All text of a session, as messages: session(Term).
*/

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
session_message(step(Device, step(_, Image, Settings, State, Decision, Reason, SetSize, Fix))) -->
    { settings_words(Device, Settings, Words),
      state_words(State, StateWords),
      merit(Fix, Merit) },
    [ '  ~w~t~6||~w~t~40+~w~t~32+'-[Image, Words, StateWords] ],
    decision(Decision),
    fix_words(Fix, Merit),
    [ '  set ~d'-[SetSize] ],
    reason(Reason).
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
session_message(report(File)) -->
    [ '  report ~w'-[File] ].
session_message(why(Why)) -->
    [ '       ', ansi(fg(cyan), '~w', [Why]) ].

decision(keep) -->
    [ ansi(fg(green), 'keep   ', []) ].
decision(discard) -->
    [ ansi(fg(red), 'discard', []) ].

fix_words(none, _) -->
    [ '  no pose              ' ].
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

prolog:error_message(server_died(Name, Status, Line, LogFile)) -->
    [ 'the ~w ended by itself (~w)'-[Name, Status] ],
    last_words(Line),
    [ nl, '  its log is ~w'-[LogFile] ].

last_words("") -->
    [].
last_words(Line) -->
    { Line \== "" },
    [ ': ~w'-[Line] ].
