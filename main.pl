:- module(lights_and_camera, []).
/** <module> One session: options in, exit status out

    swipl main.pl [options]        # --help lists them

The rest is loaded only when it is set up: it needs the compiled ZeroMQ module.
*/

:- use_module(session/installation, [installation_complete/0, installation_root/1]).
:- use_module(session/options/options, [session_options/2]).

:- initialization(main, main).

%   SWI-Prolog takes a first option that ends in `.pl` for one more file to load, and not for an argument.
:- multifile user:prolog_load_file/2.

user:prolog_load_file(Spec, _) :-
    ( Spec = user:Option ; Spec = Option ),
    atom(Option),
    sub_atom(Option, 0, _, _, '--'),
    !,
    current_prolog_flag(argv, Others),
    set_prolog_flag(argv, [Option|Others]).

main :-
    current_prolog_flag(argv, Argv),
    ( getenv('NO_COLOR', No), No \== '' -> set_prolog_flag(color_term, false) ; true ),
    catch(session_options(Argv, Options), error(usage_error(Message), _), give_up(Message)),
    (   installation_complete
    ->  true
    ;   give_up("not set up yet: run `make setup` first")
    ),
    installation_root(Root),
    load(Root, '/session/opening'),     % the servers start while the rest is loaded
    session_opening:open_session(Options, Opened),
    load(Root, '/session/run'),
    session_run:run_session(Options, Opened, Status),
    halt(Status).

%   Nothing is looked for meanwhile that no file names: what options a library's predicates take would bring what checks
%   them, 17 ms.
load(Root, Path) :-
    atom_concat(Root, Path, File),
    current_prolog_flag(autoload, Before),
    setup_call_cleanup(set_prolog_flag(autoload, explicit),
                       use_module(File, []),
                       set_prolog_flag(autoload, Before)).

%   As what is found later is said.
give_up(Message) :-
    installation_root(Root),
    load(Root, '/session/display/wrapping'),
    print_message(error, format("~s", [Message])),
    halt(2).
