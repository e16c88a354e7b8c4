:- module(session_holding,
          [ forget_hold/1,              % +Folder
            wait_while_held/1           % +Folder
          ]).
/** <module> A session that is told to pause, step or stop, by the file `hold` in its run folder

| `pause` | wait until the file says something else, or is gone |
| `step`  | go on, and pause after the next action              |
| `stop`  | end as by SIGTERM                                   |

Any other word lets it go on; a file without one is still being written. While it waits there is a file `held` as well: before, it is still busy with the action in which it was told to.
*/

:- use_module(folder/run_folder, [run_file/3]).
:- use_module(library(readutil), [read_file_to_string/3]).

look_again_s(0.1).                      % chosen by hand

%!  forget_hold(+Folder) is det.

forget_hold(Folder) :-
    forall(member(Name, [hold, held]), forget(Folder, Name)).

forget(Folder, Name) :-
    run_file(Folder, Name, File),
    catch(delete_file(File), error(_, _), true).

%!  wait_while_held(+Folder) is det.
%
%   Between two actions.

wait_while_held(Folder) :-
    word_held(Folder, Word),
    !,
    obeyed(Word, Folder).
wait_while_held(_).

word_held(Folder, Word) :-
    run_file(Folder, hold, File),
    exists_file(File),
    catch(read_file_to_string(File, Text, []), error(_, _), Text = ""),
    split_string(Text, "", " \n", [Word]).

obeyed("step", Folder) =>
    write_word(Folder, hold, pause).
obeyed("stop", Folder) =>
    forget(Folder, hold),
    throw(stopped(term)).
obeyed("pause", Folder) =>
    setup_call_cleanup(write_word(Folder, held, yes), wait_for_another_word(Folder, Word), forget(Folder, held)),
    obeyed(Word, Folder).
obeyed(_, _) =>
    true.

wait_for_another_word(Folder, Word) :-
    look_again_s(Seconds),
    sleep(Seconds),
    ( word_held(Folder, Now) -> true ; Now = "go" ),
    ( memberchk(Now, ["pause", ""]) -> wait_for_another_word(Folder, Word) ; Word = Now ).

write_word(Folder, Name, Word) :-
    run_file(Folder, Name, File),
    setup_call_cleanup(open(File, write, Stream), format(Stream, "~w~n", [Word]), close(Stream)).
