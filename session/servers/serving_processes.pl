:- module(session_serving_processes,
          [ serving_process/2           % +Endpoint, ?Pid
          ]).
/** <module> The processes of this machine that serve at an endpoint: by the words that they were started with */

:- use_module(library(lists), [append/3, member/2, memberchk/2]).
:- autoload(library(readutil), [read_file_to_string/3]).

%!  serving_process(+Endpoint, ?Pid) is nondet.
%
%   A process that was started to serve at Endpoint, whether it listens by now or not.

serving_process(Endpoint, Pid) :-
    (   integer(Pid)
    ->  true
    ;   directory_files('/proc', Entries),
        member(Entry, Entries),
        atom_number(Entry, Pid)
    ),
    format(atom(File), "/proc/~w/cmdline", [Pid]),
    catch(read_file_to_string(File, Line, []), error(_, _), fail),
    split_string(Line, "\0", "", Words),
    atom_string(Endpoint, Name),
    string_concat("--endpoint=", Name, Joined),
    once(( append(_, ["--endpoint", Name|_], Words) ; memberchk(Joined, Words) )).
