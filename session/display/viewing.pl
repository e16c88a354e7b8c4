:- module(session_viewing,
          [ start_view/2,               % +Options, +Folder
            view_address/1              % -Line
          ]).
/** <module> The live view of a session that is asked for with `--view`: `python -m report live` beside it

Nothing waits for it: it ends by itself when it sees that the session has ended, once it has shown how.
*/

:- use_module('../installation', [installation_python/1, installation_root/1]).
:- use_module(library(option), [option/2]).
:- use_module(library(process), [process_create/3]).
:- use_module(library(readutil), [read_line_to_string/2]).

:- dynamic
    address_comes/1.                    % Stream

%!  start_view(+Options, +Folder) is det.

start_view(Options, Folder) :-
    option(view(true), Options),
    !,
    installation_root(Root),
    installation_python(Python),
    current_prolog_flag(pid, Parent),
    process_create(Python, ['-m', report, live, Folder, '--parent', Parent],
                   [ process(_), cwd(Root), stdin(null), stdout(pipe(Stream)), detached(true) ]),
    assertz(address_comes(Stream)).
start_view(_, _).

%!  view_address(-Line) is semidet.
%
%   What the view says of its address, once: as soon as it is there.

view_address(Line) :-
    address_comes(Stream),
    wait_for_input([Stream], [Stream], 0),
    retract(address_comes(Stream)),
    call_cleanup(read_line_to_string(Stream, Line), close(Stream)),
    string(Line).
