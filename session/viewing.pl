:- module(session_viewing,
          [ start_view/2,               % +Options, +Folder
            stop_view/0
          ]).
:- use_module(installation, [installation_python/1, installation_root/1]).
:- use_module(processes, [wait_until/3]).
:- use_module(library(option), [option/2]).
:- use_module(library(process), [process_create/3, process_kill/2, process_wait/3]).

/** <module> The live view of a session that is asked for with `--view`: `python -m report live` beside it */

:- dynamic
    view/1.                             % Pid

last_look_s(8).                         % for the last state to be drawn and sent; chosen by hand, it takes one or two

%!  start_view(+Options, +Folder) is det.
%
%   It prints its address itself, to standard error.

start_view(Options, Folder) :-
    option(view(true), Options),
    !,
    installation_root(Root),
    installation_python(Python),
    current_prolog_flag(pid, Parent),
    process_create(Python, ['-m', report, live, Folder, '--parent', Parent],
                   [ process(Pid), cwd(Root), stdin(null), stdout(stream(user_error)), detached(true) ]),
    assertz(view(Pid)).
start_view(_, _).

%!  stop_view is det.
%
%   Once it has shown how the session ended.

stop_view :-
    forall(retract(view(Pid)), catch(stop(Pid), error(_, _), true)).

stop(Pid) :-
    process_kill(Pid, term),
    last_look_s(Seconds),
    get_time(Now),
    Deadline is Now + Seconds,
    wait_until(Deadline, Pid, Status),
    (   Status == timeout
    ->  process_kill(Pid, kill),
        process_wait(Pid, _, [])
    ;   true
    ).
