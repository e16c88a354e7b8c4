:- module(session_servers,
          [ start_servers/4,            % +Options, +Plan, +Folder, -Servers
            restarted_by/4,             % +Options, +Plan, +Folder, -Args
            check_servers/0,
            stop_servers/0
          ]).
:- use_module(kept_servers).
:- use_module(processes).
:- use_module(resumption, [captures_taken/2]).
:- use_module(run_folder, [run_file/3]).
:- use_module(library(lists), [append/2, append/3, member/2]).
:- use_module(library(option), [option/2]).

/** <module> The servers of a session: the user's, kept ones, or started here */

:- dynamic
    server/1,                           % process(...) that this session started, and ends
    kept/1.                             % process(...) or kept(Name, Pid, Base) that stays when this session ends

%!  start_servers(+Options, +Plan, +Folder, -Servers) is det.
%
%   Start those that the user has not named, and that do not run already where they are kept.  Servers is
%   servers(ImageServer, VisionServer, Timeout): two endpoints, and how long a request may take, seconds.

start_servers(Options, Plan, Folder, servers(ImageServer, VisionServer, Timeout)) :-
    endpoint(vision_server, Options, Plan, Folder, VisionServer),     % first: it has most to load
    endpoint(image_server, Options, Plan, Folder, ImageServer),
    % a server of our own is known to live while it is slow
    ( member(Name, [image_server, vision_server]), named(Name, Options, _) -> Timeout = 60 ; Timeout = 240 ).

endpoint(Name, Options, _, _, Endpoint) :-
    named(Name, Options, Endpoint),
    !.
endpoint(Name, Options, Plan, Folder, Endpoint) :-
    option(keep_servers(true), Options),
    !,
    arguments(Name, Options, Arguments),
    kept_server(Name, Arguments, Base, Found),
    atom_concat('ipc://', Base, Endpoint),
    (   Found == none
    ->  option(idle_s(Seconds), Options),
        session_arguments(Name, Options, Plan, Folder, More),
        kept_log(Base, LogFile),
        start(Name, Arguments, Endpoint, ['--idle-s', Seconds|More], LogFile, Process),
        keep_server(Base, Process),
        assertz(kept(Process))
    ;   assertz(kept(Found))
    ).
endpoint(Name, Options, Plan, Folder, Endpoint) :-
    own_endpoint(Name, Endpoint),
    arguments(Name, Options, Arguments),
    session_arguments(Name, Options, Plan, Folder, More),
    atom_concat(Name, '.log', Log),
    run_file(Folder, Log, LogFile),
    current_prolog_flag(pid, Parent),
    start(Name, Arguments, Endpoint, ['--parent', Parent|More], LogFile, Process),
    assertz(server(Process)).

named(Name, Options, Endpoint) :-
    Option =.. [Name, Endpoint],
    option(Option, Options).

%   A socket file of our own: its path must be short (107 bytes), which a run folder's need not be.
own_endpoint(Name, Endpoint) :-
    current_prolog_flag(pid, Pid),
    ( getenv('TMPDIR', Temporary) -> true ; Temporary = '/tmp' ),
    format(atom(Endpoint), "ipc://~w/lights-and-camera-~w-~w", [Temporary, Pid, Name]).

start(Name, Arguments, Endpoint, More, LogFile, Process) :-
    (   Name == image_server
    ->  atom_concat(Endpoint, '-events', Events),
        Listening = ['--endpoint', Endpoint, '--events', Events]
    ;   Listening = ['--endpoint', Endpoint]
    ),
    append([Arguments, Listening, More], Words),
    start_server(Name, Words, LogFile, Process).

%!  check_servers is det.
%
%   @error server_died(Name, Status, LastLine, LogFile) if one that this session started or found has ended

check_servers :-
    forall(( server(Process) ; kept(Process) ), check_alive(Process)).

%!  restarted_by(+Options, +Plan, +Folder, -Args) is semidet.
%
%   Arguments of the request `restart` for an image server that has served another session.

restarted_by(Options, Plan, Folder, _{seed:(Plan.seed), captures_taken:Taken}) :-
    kept(kept(image_server, _, _)),
    taken(Options, Folder, Taken).

%!  stop_servers is det.
%
%   Stop those that were started here and are not to stay.

stop_servers :-
    findall(Process, retract(server(Process)), Processes),
    stop_processes(Processes),
    retractall(kept(_)).

%   What a server is started with, whatever the session; and what only this session says.
arguments(vision_server, Options, [serve|Keys]) :-
    key_arguments(Options, Keys).
arguments(image_server, Options, Arguments) :-
    image_source(Options, Source),
    key_arguments(Options, Keys),
    append(Source, Keys, Arguments).

session_arguments(image_server, Options, Plan, Folder, ['--seed', Plan.seed, '--captures-taken', Taken]) :-
    \+ option(camera(_), Options),
    !,
    taken(Options, Folder, Taken).
session_arguments(_, _, _, _, []).

taken(Options, Folder, Taken) :-
    (   option(resume(_), Options)
    ->  captures_taken(Folder, Taken)
    ;   Taken = 0
    ).

key_arguments(Options, ['--keys', Folder]) :-
    option(keys(Folder), Options),
    !.
key_arguments(_, []).

image_source(Options, [hardware|Arguments]) :-
    option(camera(_), Options),
    !,
    findall([Dashed, Value],
            ( member(Name-Dashed, [ camera-'--camera', lights-'--lights', target-'--target', unit-'--unit',
                                    camera_model-'--camera-model', seed_pose-'--seed-pose' ]),
              Option =.. [Name, Value],
              option(Option, Options) ),
            Pairs),
    append(Pairs, Arguments).
image_source(Options, [replay, '--stack', Stack]) :-
    option(stack(Dir), Options),
    !,
    absolute_file_name(Dir, Stack).
image_source(Options, [simulator, '--target', Target, '--scenario', Scenario|Unit]) :-
    option(target(GivenTarget), Options),
    option(scenario(GivenScenario), Options),
    name_or_absolute(GivenTarget, Target),
    name_or_absolute(GivenScenario, Scenario),
    ( option(unit(Given), Options) -> Unit = ['--unit', Given] ; Unit = [] ).

%   A file is named so that it is the same from every folder.
name_or_absolute(Given, File) :-
    file_name_extension(_, Extension, Given),
    Extension \== '',
    !,
    absolute_file_name(Given, File).
name_or_absolute(Name, Name).
