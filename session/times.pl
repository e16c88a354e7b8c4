:- module(session_times,
          [ forget_times/1,             % +Folder
            session_seconds/1,          % -Pairs
            tell_times/3                % +Options, +Folder, +Action
          ]).
/** <module> Where the time of a session went, in seconds

Its result tells it at the end.  While it runs and has a view, the file `seconds.json` in its folder tells it so far: the
journal does not, so that the same session leaves the same journal.
*/

:- use_module(servers/connections, [seconds_spent/2]).
:- use_module(folder/run_folder, [replace_file/2, run_file/3]).
:- use_module(library(apply), [foldl/4]).
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(option), [option/2]).

%!  session_seconds(-Pairs) is det.
%
%   Part-Seconds pairs so far: `total` since the process began, `controller`, `bridge`, and those of the servers.  What
%   the servers did not use of the time they were waited for is the bridge's.

session_seconds([total-Total, controller-Controller, bridge-Bridge|Parts]) :-
    statistics(epoch, Start),
    get_time(Now),
    Total is max(0.0, Now - Start),     % who sets the clock back makes no negative time
    seconds_spent(Waiting, Parts),
    foldl(add_part, Parts, 0.0, Served),
    Controller is max(0.0, Total - Waiting),
    Bridge is max(0.0, Waiting - Served).

add_part(_-Seconds, Sum0, Sum) :-
    Sum is Sum0 + Seconds.

%!  tell_times(+Options, +Folder, +Action) is det.
%
%   For who watches, after each image that was judged.

tell_times(Options, Folder, Action) :-
    judged(Action),
    option(view(true), Options),
    !,
    session_seconds(Pairs),
    dict_pairs(Seconds, seconds, Pairs),
    run_file(Folder, 'seconds.json', File),
    catch(replace_file(File, write_seconds(Seconds)), error(_, _), true). % no session fails for its view
tell_times(_, _, _).

write_seconds(Seconds, Stream) :-
    json_write_dict(Stream, Seconds, [width(0)]).

judged(keep(_)).
judged(discard(_, _)).

%!  forget_times(+Folder) is det.

forget_times(Folder) :-
    run_file(Folder, 'seconds.json', File),
    catch(delete_file(File), error(_, _), true).
