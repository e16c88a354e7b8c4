:- module(session_servers,
          [ start_servers/4,            % +Options, +Plan, +Folder, -Servers
            own_server/1,               % ?Name
            served_before/1,            % ?Name
            check_server/1,             % +Name
            start_again/1,              % +Name
            kill_server/1,              % +Name
            stop_servers/0,
            image_server_past/1,        % -Args
            captures_taken/1,           % -Count
            add_to_past/1               % +Action
          ]).
/** <module> The servers of a session: the user's, kept ones, or started here */

:- use_module('../installation', [installation_root/1]).
:- use_module(kept_servers).
:- use_module(processes).
:- autoload('../folder/resumption', [journaled_action/2]).
:- use_module('../folder/run_folder', [run_file/3]).
:- use_module(library(lists), [append/2, append/3, member/2, memberchk/2, reverse/2]).
:- use_module(library(option), [option/2]).

:- dynamic
    server/2,                           % Name, process(...) that this session started, and ends
    kept/2,                             % Name, process(...) or kept(Name, Pid, Base) that stays when this session ends
    begun/4,                            % Name, `own` or kept(Base), Words, LogFile: how one is started
    frames/1,                           % folder of the session's frames
    past/3.                             % Seed, Captures, Moves: what the image server has done in this session; moves
                                        % are move(RangeM, Captures), newest first

%!  start_servers(+Options, +Plan, +Folder, -Servers) is det.
%
%   Start those that the user has not named, and that do not run already where they are kept.  Servers is
%   servers(ImageServer, VisionServer): two endpoints.

start_servers(Options, Plan, Folder, servers(ImageServer, VisionServer)) :-
    set_past(Options, Plan, Folder),
    run_file(Folder, images, Images),
    retractall(frames(_)),
    assertz(frames(Images)),
    endpoint(vision_server, Options, Plan, Folder, VisionServer),       % first: it has most to load
    endpoint(image_server, Options, Plan, Folder, ImageServer).

set_past(Options, Plan, Folder) :-
    retractall(past(_, _, _)),
    assertz(past(Plan.seed, 0, [])),
    (   option(resume(_), Options)
    ->  forall(journaled_action(Folder, Action), add_to_past(Action))
    ;   true
    ).

%!  captures_taken(-Count) is det.

captures_taken(Captures) :-
    past(_, Captures, _).

%!  add_to_past(+Action) is det.
%
%   The image server has done its part of an action of the session.

add_to_past(capture(_, _)) =>
    retract(past(Seed, Captures0, Moves)),
    Captures is Captures0 + 1,
    assertz(past(Seed, Captures, Moves)).
add_to_past(advance(RangeM)) =>
    retract(past(Seed, Captures, Moves)),
    assertz(past(Seed, Captures, [move(RangeM, Captures)|Moves])).
add_to_past(_) =>
    true.

%!  image_server_past(-Args) is det.
%
%   Arguments of the request `restart` that makes an image server what it is in this session.

image_server_past(_{seed:Seed, captures_taken:Captures, moves:Moves}) :-
    past(Seed, Captures, Newest),
    findall(_{range_m:RangeM, captures_taken:Taken}, member(move(RangeM, Taken), Newest), Reversed),
    reverse(Reversed, Moves).

endpoint(Name, Options, _, _, Endpoint) :-
    named(Name, Options, Endpoint),
    !.
endpoint(Name, Options, _, _, Endpoint) :-
    option(keep_servers(true), Options),
    !,
    arguments(Name, Options, Arguments),
    kept_server(Name, Arguments, Base, Found),
    atom_concat('ipc://', Base, Endpoint),
    option(idle_s(Seconds), Options),
    kept_log(Base, LogFile),
    listening(Name, Arguments, Endpoint, ['--idle-s', Seconds], Words),
    assertz(begun(Name, kept(Base), Words, LogFile)),
    ( Found == none -> start(Name, '>') ; assertz(kept(Name, Found)) ).
endpoint(Name, Options, Plan, Folder, Endpoint) :-
    own_endpoint(Name, Endpoint),
    arguments(Name, Options, Arguments),
    atom_concat(Name, '.log', Log),
    run_file(Folder, Log, LogFile),
    current_prolog_flag(pid, Parent),
    roots(Name, Options, Plan, Folder, Roots),
    listening(Name, Arguments, Endpoint, ['--parent', Parent|Roots], Words),
    assertz(begun(Name, own, Words, LogFile)),
    start(Name, '>').

%   A vision server of this session alone reads and writes what the session names; the model of its image server lies
%   wherever that says.
roots(image_server, _, _, _, []).
roots(vision_server, Options, Plan, Folder, Words) :-
    installation_root(Root),
    findall(['--root', Place],
            ( member(Place, [Folder, Root])
            ; ( File = Plan.model, File \== none
              ; member(Name, [camera_model, seed_pose]), named(Name, Options, File)
              ),
              absolute_file_name(File, Absolute),
              file_directory_name(Absolute, Place)
            ),
            Roots),
    ( named(image_server, Options, ImageServer) -> true ; own_endpoint(image_server, ImageServer) ),
    append([['--image-server', ImageServer]|Roots], Words).

named(Name, Options, Endpoint) :-
    Option =.. [Name, Endpoint],
    option(Option, Options).

%   A socket file of our own: its path must be short (107 bytes), which a run folder's need not be.
own_endpoint(Name, Endpoint) :-
    current_prolog_flag(pid, Pid),
    ( getenv('TMPDIR', Temporary) -> true ; Temporary = '/tmp' ),
    format(atom(Endpoint), "ipc://~w/lights-and-camera-~w-~w", [Temporary, Pid, Name]).

listening(image_server, Arguments, Endpoint, More, Words) :-
    !,
    atom_concat(Endpoint, '-events', Events),
    append([Arguments, ['--endpoint', Endpoint, '--events', Events], More], Words).
listening(_, Arguments, Endpoint, More, Words) :-
    append([Arguments, ['--endpoint', Endpoint], More], Words).

%   Start it as begun/4 says; Redirection makes its log anew, or goes on with it.
start(Name, Redirection) :-
    begun(Name, Stay, Words0, LogFile),
    past_arguments(Words0, Past),
    append(Words0, Past, Words),
    start_server(Name, Words, Redirection, LogFile, Process),
    (   Stay = kept(Base)
    ->  keep_server(Base, Process),
        assertz(kept(Name, Process))
    ;   assertz(server(Name, Process))
    ).

%   What is drawn, and what has been done in this session: of the devices that draw.
past_arguments([Device|_], ['--seed', Seed, '--captures-taken', Captures|Moved]) :-
    memberchk(Device, [replay, simulator]),
    !,
    past(Seed, Captures, Newest),
    reverse(Newest, Moves),
    findall(['--moved', Word],
            ( member(move(RangeM, Taken), Moves), format(atom(Word), "~w:~w", [RangeM, Taken]) ),
            Moves0),
    (   Device == replay,
        Captures > 0                    % recorded frames that were shown do not come again
    ->  frames(Images),
        append([['--shown', Images]|Moves0], Moved)
    ;   append(Moves0, Moved)
    ).
past_arguments(_, []).

%!  own_server(?Name) is nondet.
%
%   One that this session started, or found where such are kept.

own_server(Name) :-
    begun(Name, _, _, _).

%!  served_before(?Name) is nondet.
%
%   One that was found where they are kept.

served_before(Name) :-
    kept(Name, kept(_, _, _)).

%!  check_server(+Name) is det.
%
%   @error server_died(Name, Status, LastLine, LogFile) if it was started or found by this session, and has ended

check_server(Name) :-
    forall(( server(Name, Process) ; kept(Name, Process) ), check_alive(Process)).

%!  start_again(+Name) is det.
%
%   Start one that has ended, where it was, with all that was done in this session.

start_again(Name) :-
    retractall(server(Name, _)),
    retractall(kept(Name, _)),
    start(Name, '>>').

%!  kill_server(+Name) is det.

kill_server(Name) :-
    forall(( server(Name, Process) ; kept(Name, Process) ), kill_process(Process)).

%!  stop_servers is det.
%
%   Stop those that were started here and are not to stay.

stop_servers :-
    findall(Process, retract(server(_, Process)), Processes),
    stop_processes(Processes),
    forall(begun(Name, own, _, _), delete_sockets(Name)),
    retractall(kept(_, _)),
    retractall(begun(_, _, _, _)).

%   A server that was killed could not do it.
delete_sockets(Name) :-
    own_endpoint(Name, Endpoint),
    atom_concat('ipc://', Socket, Endpoint),
    forall(member(Suffix, ['', '-events']),
           ( atom_concat(Socket, Suffix, File), catch(delete_file(File), error(_, _), true) )).

%   What a server is started with, whatever the session.
arguments(vision_server, Options, [serve|Keys]) :-
    key_arguments(Options, Keys).
arguments(image_server, Options, Arguments) :-
    image_source(Options, Source),
    key_arguments(Options, Keys),
    append(Source, Keys, Arguments).

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
image_source(Options, [replay, '--nearest', '--stack', Stack]) :-
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
