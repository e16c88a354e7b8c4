:- module(indigolog_values,
          [ no_values/1,              % -Values
            stored/3,                 % +Values, +Fluent, -Value
            store/4,                  % +Values, +Fluent, +Value, -Values1
            stored_pair/3,            % +Values, ?Fluent, -Value
            stored_pairs/2,           % +Values, -Pairs
            values_of_pairs/2         % +Pairs, -Values
          ]).
:- use_module(library(assoc), [assoc_to_list/2, empty_assoc/1, gen_assoc/3, get_assoc/3, list_to_assoc/2, put_assoc/4]).

/** <module> The values that a situation stores

Values is a balanced tree (library(assoc)); once that has grown, recent(Recent, Old): a
small tree of what was set last over the large one, so that setting a fluent that is set
often costs what it costs in a small theory.
*/

no_values(Values) :-
    empty_assoc(Values).

%!  stored(+Values, +Fluent, -Value) is semidet.

stored(Values, F, V) :-
    (   Values = recent(Recent, Old)
    ->  (   get_assoc(F, Recent, V0)
        ->  V = V0
        ;   get_assoc(F, Old, V)
        )
    ;   get_assoc(F, Values, V)
    ).

%!  store(+Values, +Fluent, +Value, -Values1) is det.

store(Values, F, V, Values1) :-
    (   Values = recent(Recent0, Old)
    ->  put_assoc(F, Recent0, V, Recent),
        (   grown(Recent)
        ->  assoc_to_list(Recent, Pairs),
            put_pairs(Pairs, Old, Old1),
            empty_assoc(Empty),
            Values1 = recent(Empty, Old1)
        ;   Values1 = recent(Recent, Old)
        )
    ;   put_assoc(F, Values, V, Values0),
        (   large(Values0)
        ->  empty_assoc(Empty),
            Values1 = recent(Empty, Values0)
        ;   Values1 = Values0
        )
    ).

put_pairs([], Tree, Tree).
put_pairs([F-V|Pairs], Tree0, Tree) :-
    put_assoc(F, Tree0, V, Tree1),
    put_pairs(Pairs, Tree1, Tree).

% Told from the depth of a tree on one side: grown/1 from 7 fluents on, large/1 from 33 on.
grown(t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, _, _), _), _), _)).

large(t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, t(_, _, _, _, _), _), _), _), _), _), _)).

%!  stored_pair(+Values, ?Fluent, -Value) is nondet.

stored_pair(recent(Recent, Old), F, V) =>
    (   gen_assoc(F, Recent, V)
    ;   gen_assoc(F, Old, V),
        \+ get_assoc(F, Recent, _)
    ).
stored_pair(Values, F, V) =>
    gen_assoc(F, Values, V).

%!  stored_pairs(+Values, -Pairs) is det.
%
%   Pairs is the list of Fluent-Value in the standard order of the fluents.

stored_pairs(recent(Recent, Old), Pairs) =>
    assoc_to_list(Recent, RecentPairs),
    put_pairs(RecentPairs, Old, All),
    assoc_to_list(All, Pairs).
stored_pairs(Values, Pairs) =>
    assoc_to_list(Values, Pairs).

%!  values_of_pairs(+Pairs, -Values) is det.

values_of_pairs(Pairs, Values) :-
    list_to_assoc(Pairs, Values).
