:- module(session_holding,
          [ forget_hold/1,              % +Folder
            wait_while_held/1           % +Folder
          ]).
:- use_module(run_folder, [run_file/3]).
:- use_module(library(readutil), [read_file_to_string/3]).

/** <module> A session that is told to pause, step or stop, by the file `hold` in its run folder

| `pause` | wait until the file says something else, or is gone |
| `step`  | go on, and pause after the next action              |
| `stop`  | end as by SIGTERM                                   |
*/

look_again_s(0.1).                      % chosen by hand

%!  forget_hold(+Folder) is det.

forget_hold(Folder) :-
    run_file(Folder, hold, File),
    catch(delete_file(File), error(_, _), true).

%!  wait_while_held(+Folder) is det.
%
%   Between two actions.

wait_while_held(Folder) :-
    run_file(Folder, hold, File),
    exists_file(File),
    !,
    catch(read_file_to_string(File, Text, []), error(_, _), Text = ""),
    split_string(Text, "", " \n", [Word]),
    obeyed(Word, Folder, File).
wait_while_held(_).

obeyed("step", _, File) =>
    setup_call_cleanup(open(File, write, Stream), format(Stream, "pause~n", []), close(Stream)).
obeyed("stop", _, File) =>
    catch(delete_file(File), error(_, _), true),
    throw(stopped(term)).
obeyed(_, Folder, _) =>
    look_again_s(Seconds),
    sleep(Seconds),
    wait_while_held(Folder).
