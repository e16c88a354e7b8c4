:- module(indigolog_values,
          [ no_values/1,              % -Values
            stored/3,                 % +Values, +Fluent, -Value
            store/4,                  % +Values, +Fluent, +Value, -Values1
            stored_pair/3,            % +Values, ?Fluent, -Value
            stored_pairs/2,           % +Values, -Pairs
            values_of_pairs/2         % +Pairs, -Values
          ]).
/** <module> The values that a situation stores

Values is a balanced tree (library(assoc)); once that has grown, recent(Count, Recent, Old):
a short list of what was set last, newest first, over the large tree, so that setting a
fluent that is set often costs what it costs in a small theory.
*/

:- use_module(library(assoc), [assoc_to_list/2, empty_assoc/1, gen_assoc/3, get_assoc/3, list_to_assoc/2, put_assoc/4]).
:- use_module(library(lists), [member/2, memberchk/2, selectchk/3]).

% Most fluents in the list; chosen by hand.
most_recent(8).

no_values(Values) :-
    empty_assoc(Values).

%!  stored(+Values, +Fluent, -Value) is semidet.

stored(Values, F, V) :-
    (   Values = recent(_, Recent, Old)
    ->  (   memberchk(F-V0, Recent)
        ->  V = V0
        ;   get_assoc(F, Old, V)
        )
    ;   get_assoc(F, Values, V)
    ).

%!  store(+Values, +Fluent, +Value, -Values1) is det.

store(Values, F, V, Values1) :-
    (   Values = recent(N, Recent, Old)
    ->  stored_recently(Recent, N, Old, F, V, Values1)
    ;   put_assoc(F, Values, V, Values0),
        (   large(Values0)
        ->  Values1 = recent(0, [], Values0)
        ;   Values1 = Values0
        )
    ).

stored_recently(Recent, N, Old, F, V, Values1) :-
    (   Recent = [F0-_|Others],
        F0 == F
    ->  Values1 = recent(N, [F-V|Others], Old)
    ;   selectchk(F-_, Recent, Others)
    ->  Values1 = recent(N, [F-V|Others], Old)
    ;   most_recent(Most),
        N < Most
    ->  N1 is N+1,
        Values1 = recent(N1, [F-V|Recent], Old)
    ;   put_pairs(Recent, Old, Old1),
        Values1 = recent(1, [F-V], Old1)
    ).

put_pairs([], Tree, Tree).
put_pairs([F-V|Pairs], Tree0, Tree) :-
    put_assoc(F, Tree0, V, Tree1),
    put_pairs(Pairs, Tree1, Tree).

% Told from the depth of the tree on one side: it has at least 33 fluents.
large(t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, _, _), _), _), _), _), _), _)).

%!  stored_pair(+Values, ?Fluent, -Value) is nondet.

stored_pair(recent(_, Recent, Old), F, V) =>
    (   member(F-V, Recent)
    ;   gen_assoc(F, Old, V),
        \+ memberchk(F-_, Recent)
    ).
stored_pair(Values, F, V) =>
    gen_assoc(F, Values, V).

%!  stored_pairs(+Values, -Pairs) is det.
%
%   Pairs is the list of Fluent-Value in the standard order of the fluents.

stored_pairs(recent(_, Recent, Old), Pairs) =>
    put_pairs(Recent, Old, All),
    assoc_to_list(All, Pairs).
stored_pairs(Values, Pairs) =>
    assoc_to_list(Values, Pairs).

%!  values_of_pairs(+Pairs, -Values) is det.

values_of_pairs(Pairs, Values) :-
    list_to_assoc(Pairs, Values).
