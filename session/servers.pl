:- module(session_servers,
          [ start_servers/4,            % +Options, +Plan, +Folder, -Servers
            check_servers/0,
            stop_servers/0
          ]).
:- use_module(processes).
:- use_module(resumption, [captures_taken/2]).
:- use_module(run_folder, [run_file/3]).
:- use_module(library(lists), [append/2, append/3, member/2]).
:- use_module(library(option), [option/2]).

/** <module> The servers of a session: the user's, or started here */

:- dynamic server/1.                    % process that this session started

%!  start_servers(+Options, +Plan, +Folder, -Servers) is det.
%
%   Start those that the user has not named.  Servers is servers(ImageServer,
%   VisionServer, Timeout): two endpoints, and how long a request may take, seconds.

start_servers(Options, Plan, Folder, servers(ImageServer, VisionServer, Timeout)) :-
    endpoint(vision_server, Options, VisionServer, StartVisionServer),
    endpoint(image_server, Options, ImageServer, StartImageServer),
    (   StartVisionServer == true       % first: it has most to load
    ->  key_arguments(Options, Keys),
        start(vision_server, [serve, '--endpoint', VisionServer|Keys], Folder)
    ;   true
    ),
    (   StartImageServer == true
    ->  image_server_arguments(Options, Plan, ImageServer, Folder, Arguments),
        start(image_server, Arguments, Folder)
    ;   true
    ),
    % a server of our own is known to live while it is slow
    (   StartImageServer == true, StartVisionServer == true -> Timeout = 240 ; Timeout = 60 ).

start(Name, Arguments, Folder) :-
    atom_concat(Name, '.log', Log),
    run_file(Folder, Log, LogFile),
    start_server(Name, Arguments, LogFile, Process),
    assertz(server(Process)).

%!  check_servers is det.
%
%   @error server_died(Name, Status, LastLine, LogFile) if one that was started here has ended

check_servers :-
    forall(server(Process), check_alive(Process)).

%!  stop_servers is det.
%
%   Stop those that were started here.

stop_servers :-
    findall(Process, retract(server(Process)), Processes),
    stop_processes(Processes).

%   An endpoint is the user's, or a socket file of our own: its path must be short
%   (107 bytes), which a run folder's need not be.
endpoint(Name, Options, Endpoint, false) :-
    Option =.. [Name, Endpoint],
    option(Option, Options),
    !.
endpoint(Name, _, Endpoint, true) :-
    current_prolog_flag(pid, Pid),
    format(atom(Base), "lights-and-camera-~w-~w", [Pid, Name]),
    ( getenv('TMPDIR', Temporary) -> true ; Temporary = '/tmp' ),
    atomic_list_concat(['ipc://', Temporary, /, Base], Endpoint).

image_server_arguments(Options, Plan, Endpoint, Folder, Arguments) :-
    image_source(Options, Plan, Folder, Source),
    atom_concat(Endpoint, '-events', Events),
    key_arguments(Options, Keys),
    append([Source, ['--endpoint', Endpoint, '--events', Events], Keys], Arguments).

key_arguments(Options, ['--keys', Folder]) :-
    option(keys(Folder), Options),
    !.
key_arguments(_, []).

image_source(Options, _, _, [hardware|Arguments]) :-
    option(camera(_), Options),
    !,
    findall([Dashed, Value],
            ( member(Name-Dashed, [ camera-'--camera', lights-'--lights', target-'--target',
                                    camera_model-'--camera-model', seed_pose-'--seed-pose' ]),
              Option =.. [Name, Value],
              option(Option, Options) ),
            Pairs),
    append(Pairs, Arguments).
image_source(Options, Plan, Folder, Arguments) :-
    (   option(stack(Dir), Options)
    ->  absolute_file_name(Dir, Stack),
        Source = [replay, '--stack', Stack]
    ;   option(target(Target), Options),
        option(scenario(Scenario), Options),
        Source = [simulator, '--target', Target, '--scenario', Scenario]
    ),
    (   option(resume(_), Options)
    ->  captures_taken(Folder, Taken)
    ;   Taken = 0
    ),
    append(Source, ['--seed', Plan.seed, '--captures-taken', Taken], Arguments).
