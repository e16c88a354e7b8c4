:- module(session_opening,
          [ open_session/2,             % +Options, -Opened
            end_if_stopped/0
          ]).
/** <module> What a session begins with, before the controller is loaded

The servers take longer to start than everything else in a short session, so they
are started first; the controller is loaded and checked meanwhile.  Ctrl-C and SIGTERM wait for that: what was
begun is then ended by who knows how.
*/

:- use_module(options/plan).
:- autoload('folder/resumption', [check_frames/1]).
:- use_module(folder/run_folder).
:- use_module(servers/servers).
:- use_module(library(option), [option/2]).

:- dynamic
    asked_to_stop/1.                    % Signal

%!  open_session(+Options, -Opened) is det.
%
%   Opened is opened(Plan, Folder, Servers), or failed(Error): what is wrong is said by the session, which knows how.
%   To check everything the servers are started, too; their folder is then one that is removed with all that is in it.

open_session(Options, Opened) :-
    on_signal(int, _, note_stop),
    on_signal(term, _, note_stop),
    catch(opened(Options, Opened), Error, Opened = failed(Error)).

opened(Options, Opened) :-
    session_plan(Options, Plan),
    (   option(dry_run(true), Options)
    ->  check_run_folder(Options, Plan),
        tmp_file(dry_run, Folder),
        make_directory(Folder)
    ;   make_run_folder(Options, Plan, Folder),
        ( option(resume(_), Options) -> check_frames(Folder) ; true )
    ),
    catch(start_servers(Options, Plan, Folder, Servers), Error, ( leave_run_folder(Options, Folder, Error), throw(Error) )),
    Opened = opened(Plan, Folder, Servers).

:- public note_stop/1.

note_stop(Signal) :-
    assertz(asked_to_stop(Signal)).

%!  end_if_stopped is det.
%
%   @error stopped(Signal) where that came since the session was opened

end_if_stopped :-
    ( asked_to_stop(Signal) -> throw(stopped(Signal)) ; true ).
