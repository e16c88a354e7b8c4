:- module(indigolog_unused_clauses,
          [ unused_clause/4           % +Module, -Head, -Reference, -First
          ]).
/** <module> Clauses of procedures that others come before

Of the clauses of proc/2 that match a call the first counts.
*/

:- use_module(library(lists), [append/3, member/2]).
:- use_module('../language/theory', [generalised/2]).

%!  unused_clause(+Module, -Head, -Reference, -First) is nondet.
%
%   The clause Reference of the theory in Module defines Head, and First, clause(File, Line),
%   comes before it: in the `same` file it matches all calls that Head does, in another one
%   some of them.  Not where a file is included after what is to count in place of its own.

unused_clause(Module, Head, Reference, First) :-
    clause(Module:proc(Head, _), _, Reference),
    nonvar(Head),
    place(Reference, File, _, Source),
    once(( earlier_clause(Module, Head, Reference, Head1, Condition1, File1, Line1),
           (   File1 == File
           ->  Condition1 == true,
               subsumes_term(Head1, Head),
               First = clause(same, Line1)
           ;   atom_concat(File, _, Source),      % not included; more is said there of how it was loaded
               \+ Head1 \= Head,
               First = clause(File1, Line1)
           ) )).

earlier_clause(Module, Head, Reference, Head1, Condition1, File1, Line1) :-
    generalised(Head, G),
    findall(c(G, Condition, Reference0), clause(Module:proc(G, _), Condition, Reference0), Clauses),
    append(Before, [c(_, _, Reference)|_], Clauses),
    member(c(Head1, Condition1, Reference1), Before),
    place(Reference1, File1, Line1, _).

place(Reference, File, Line, Source) :-
    clause_property(Reference, file(File)),
    clause_property(Reference, line_count(Line)),
    clause_property(Reference, source(Source)).
