:- module(lights_and_camera, []).
:- use_module(session/options, [session_options/2]).

/** <module> One session: options in, exit status out

    swipl main.pl [options]        # --help lists them

The rest is loaded only when it is set up: it needs the compiled ZeroMQ module.
*/

:- initialization(main, main).

main :-
    current_prolog_flag(argv, Argv),
    catch(session_options(Argv, Options), error(usage_error(Message), _), give_up(Message)),
    root(Root),
    set_up(Root),
    load(Root, '/session/opening'),     % the servers start while the rest is loaded
    session_opening:open_session(Options, Opened),
    load(Root, '/session/run'),
    session_run:run_session(Options, Opened, Status),
    halt(Status).

load(Root, Path) :-
    atom_concat(Root, Path, File),
    use_module(File, []).

%   The folder of this file; the session may be started from any other.
root(Root) :-
    module_property(lights_and_camera, file(File)),
    file_directory_name(File, Root).

set_up(Root) :-
    (   forall(needed(Path), ( atomic_list_concat([Root, /, Path], Full), exists_file(Full) ))
    ->  true
    ;   give_up("not set up yet: run `make setup` first")
    ).

needed('.venv/bin/python').
needed('bridge/prolog/zmq4pl.so').

give_up(Message) :-
    format(user_error, "main.pl: ~s~n", [Message]),
    halt(2).
