:- module(indigolog_directives,
          [ missing/3                 % +Directive, +Module, -Missing
          ]).
/** <module> Directives of a theory that cannot be done

Most load an interpreter, which the theory has here without a word.
*/

:- use_module(library(lists), [member/2]).

%!  missing(+Directive, +Module, -Missing) is semidet.
%
%   Directive, in a file of the theory in Module, begins with a goal that loads a file that is not there, Missing = file(File),
%   or calls a predicate that is not, Missing = predicate(Name/Arity).  What follows that goal may come of it.

missing(Directive, Module, Missing) :-
    first_goal(Directive, Goal),
    callable(Goal),
    (   loads(Goal, Files)
    ->  member(File, Files),
        ground(File),
        \+ found(File),
        Missing = file(File)
    ;   \+ declares(Goal),
        \+ predicate_property(Module:Goal, visible),
        functor(Goal, Name, Arity),
        Missing = predicate(Name/Arity)
    ),
    !.

first_goal(G, G) :-
    var(G),
    !.
first_goal((G, _), First) :-
    !,
    first_goal(G, First).
first_goal(G, G).

loads(Goal, Files) :-
    (   Goal = [_|_]
    ->  Files = Goal
    ;   member(Goal, [consult(Spec), ensure_loaded(Spec), include(Spec), load_files(Spec, _)])
    ->  ( is_list(Spec) -> Files = Spec ; Files = [Spec] )
    ).

found(File) :-
    catch(absolute_file_name(File, _, [file_type(prolog), access(read), file_errors(fail)]), _, true).

% What the compiler takes for itself, and is no predicate everywhere.
declares(Goal) :-
    functor(Goal, Name, _),
    member(Name, [module, include, if, elif, else, endif, encoding, initialization, expects_dialect, (table)]),
    !.
