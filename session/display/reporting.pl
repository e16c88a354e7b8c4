:- module(session_reporting,
          [ begin_report/2,             % +Options, +Folder
            tell_report/0,
            wait_for_report/2,          % +Options, +Folder
            drop_report/0
          ]).
/** <module> The page of a session: `python -m report`, which gets ready beside the session and writes at its end

It needs longer to be loaded than to write.
*/

:- use_module(display, [show/2]).
:- use_module('../installation', [installation_python/1, installation_root/1]).
:- use_module('../servers/processes', [ended_or_killed/3]).
:- use_module('../folder/run_folder', [run_file/3]).
:- use_module(library(option), [option/2]).
:- use_module(library(process), [process_create/3]).

:- dynamic
    ready/2,                            % Pid, In: waits for a line on In
    writing/1.                          % Pid: has been told to write

report_seconds(60).                     % for report.html to be written; chosen by hand, it takes less than one

%!  begin_report(+Options, +Folder) is det.
%
%   Where it cannot be started, that is said at the end.

begin_report(Options, Folder) :-
    option(report(true), Options),
    catch(start(Folder), error(_, _), fail),
    !.
begin_report(_, _).

start(Folder) :-
    installation_root(Root),
    installation_python(Python),
    process_create(Python, ['-m', report, Folder, '--when-told'],
                   [ process(Pid), cwd(Root), stdin(pipe(In)), stdout(null), detached(true) ]),
    assertz(ready(Pid, In)).

%!  tell_report is det.
%
%   All that it shows is in the folder now.

tell_report :-
    retract(ready(Pid, In)),
    !,
    catch(nl(In), error(_, _), true),   % of one that has ended the status is told
    close(In, [force(true)]),
    assertz(writing(Pid)).
tell_report.

%!  wait_for_report(+Options, +Folder) is det.
%
%   Until report.html is written, if it was asked for; say where it is.

wait_for_report(Options, Folder) :-
    option(report(true), Options),
    !,
    ( catch(written(Status), error(_, _), fail) -> true ; Status = failed ),
    (   Status == exit(0)
    ->  run_file(Folder, 'report.html', File),
        show(Options, report(File))
    ;   print_message(warning, session(no_report(Folder, Status)))
    ).
wait_for_report(_, _).

written(Status) :-
    retract(writing(Pid)),
    report_seconds(Seconds),
    ended_or_killed(Seconds, Pid, Status).

%!  drop_report is det.
%
%   Nothing is to be written any more.

drop_report :-
    forall(retract(ready(Pid, In)), ( close(In, [force(true)]), end(Pid) )),
    forall(retract(writing(Pid)), end(Pid)).

end(Pid) :-
    catch(ended_or_killed(0, Pid, _), error(_, _), true).
