:- module(test_indigolog_open_effects, []).
:- use_module(library(plunit)).
:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(random), [random_between/3, random_member/2, random_permutation/2]).
:- use_module('../../indigolog/indigolog').
:- use_module(naive_values).
:- use_module(theory_text).

/** <module> Effects on infinitely many instances of a fluent, and on those that a list names */

:- begin_tests(open_effects, [setup(load)]).

load :-
    load_text(
        "fun_fluent(v(_)).
         initially(v(_), 7).
         prim_action(put(_, _)).       poss(put(_, _), true).  causes_val(put(K, X), v(K), X, true).
         prim_action(reset).           poss(reset, true).      causes_val(reset, v(_), 0, true).
         prim_action(but_one).         poss(but_one, true).    causes_val(but_one, v(1), 5, true).
                                                               causes_val(but_one, v(_), 0, true).
         prim_action(all_first).       poss(all_first, true).  causes_val(all_first, v(_), 0, true).
                                                               causes_val(all_first, v(1), 5, true).
         prim_action(boost).           poss(boost, true).      causes_val(boost, v(K), 99, K > 3).
                                                               causes_val(boost, v(K), 1, neg(K = 2)).
         prim_action(told(_)).         poss(told(_), true).    causes_val(told(L), v(K), X, member(K-X, L)).
         prim_action(told_of(_)).      poss(told_of(_), true).
         causes_val(told_of(L), v(K), X, and([member(K-Y, L), X is v(K) + Y])).").

% Newest action first.
test(value, [forall(member(History-Fluent-Value,
                           [ [reset]-v(3)-0, [but_one]-v(1)-5, [but_one]-v(2)-0, [all_first]-v(1)-0,
                             [boost]-v(4)-99, [boost]-v(3)-1, [boost]-v(2)-7, [boost, put(2, 8)]-v(2)-8,
                             [put(1, 3), but_one]-v(1)-3, [told([1-3, 1-4])]-v(1)-3, [told([2-3])]-v(1)-7,
                             [told_of([1-3, 2-4]), put(1, 1)]-v(1)-4 ])),
             true(Values == [Value])]) :-
    findall(V, holds(Fluent = V, History), Values).

test(instances, [forall(member(History-Known,
                               [ [told([1-3, 2-4])]-[1-3, 2-4, '_'-7], [put(2, 9)]-[2-9, '_'-7],
                                 [reset]-['_'-0], [reset, put(2, 9)]-['_'-0],
                                 [put(a, 1), reset, put(b, 2)]-[a-1, '_'-0],
                                 [but_one]-[1-5, '_'-0], [all_first]-['_'-0],
                                 [boost, put(2, 8), put(5, 0)]-[5-99, 2-8, '_'-7] ])),
             true(Instances == Sorted)]) :-
    msort(Known, Sorted),
    findall(K-V, ( holds(v(K) = V, History), ( var(K) -> K = '_' ; true ) ), Instances0),
    msort(Instances0, Instances).

% The same where other fluents may have several values, on which effects may depend.
test(possible_values, [forall(member(History-Fluent-Possible,
                                     [ [reset]-v(3)-[0], [reset, put(3, 1)]-v(3)-[0],
                                       [put(3, 1), reset]-v(3)-[1], [if_box]-v(2)-[5, 7],
                                       [if_box]-v(1)-[5, 6], [if_box, reset]-v(2)-[5, 0],
                                       [knock(1), if_box]-v(2)-[5, 7], [hidden, reset]-v(1)-[9, 0],
                                       [hidden, reset]-v(3)-[0], [e(look, 9), look]-v(2)-[9],
                                       [e(peek, 9), peek]-v(2)-[7],
                                       [e(peek, 9), peek, e(knock(2), yes)]-v(2)-[9] ])),
                      setup(load_uncertain), cleanup(load), true(Values == Possible)]) :-
    findall(V, ( member(V, [0, 1, 5, 6, 7, 9]), \+ holds(neg(Fluent = V), History) ), Values0),
    msort(Possible, Sorted),
    ( Values0 == Sorted -> Values = Possible ; Values = Values0 ).

load_uncertain :-
    load_text(
        "fun_fluent(v(_)).             initially(v(_), 7).
         fun_fluent(box).              initially(box, 1).      initially(box, 2).
         prim_action(knock(_)).        poss(knock(_), true).   settles(knock(B), yes, box, B, true).
         prim_action(put(_, _)).       poss(put(_, _), true).  causes_val(put(K, X), v(K), X, true).
         prim_action(reset).           poss(reset, true).      causes_val(reset, v(_), 0, true).
         prim_action(look).            poss(look, true).       senses(look, R, v(_), R, true).
         prim_action(peek).            poss(peek, true).       senses(peek, R, v(_), R, box = 2).
         prim_action(if_box).          poss(if_box, true).     causes_val(if_box, v(_), 5, box = 1).
                                                               causes_val(if_box, v(1), 6, true).
         prim_action(hidden).          poss(hidden, true).     causes_val(hidden, v(K), 9, K = box).").

% As regression over the history has it (naive_values.pl), for axioms in any order.
test(agrees_with_regression, [forall(member(Seed, [1, 2, 3])), true(Differences == [])]) :-
    set_random(seed(Seed)),
    findall(History-K-Value-Regressed,
            ( between(1, 40, _),
              random_axioms(Axioms),
              naive_theory([fun_fluent(v(_)), initially(v(_), 7)|Axioms]),
              theory_of_axioms(Axioms),
              random_history(History),
              member(K, [1, 2, 3, 4]),
              findall(V, holds(v(K) = V, History), [Value]),
              naive_values(v(K), History, [Regressed]),
              Value \== Regressed ),
            Differences).

random_axioms(Axioms) :-
    random_permutation([ causes_val(a, v(_), 0, true), causes_val(a, v(1), 5, true),
                         causes_val(a, v(K1), 6, K1 = 2),
                         causes_val(a, v(K2), 8, neg(K2 = 3)), causes_val(b, v(K3), N3, N3 is v(K3) + 1),
                         causes_val(b, v(2), 4, v(1) = 5), causes_val(b, v(K4), 3, member(K4, [1, 4])),
                         causes_val(c, v(3), 1, true),
                         causes_val(c, v(K5), X5, and(K5 = 4, X5 is v(1) * 2)) ], All),
    random_between(3, 9, N),
    length(Axioms, N),
    append(Axioms, _, All).

random_history(History) :-
    random_between(1, 5, N),
    length(History, N),
    maplist([A]>>random_member(A, [a, b, c]), History).

theory_of_axioms(Axioms) :-
    maplist([Axiom, Text]>>format(atom(Text), '~q.~n', [Axiom]), Axioms, Texts),
    atomic_list_concat(["fun_fluent(v(_)). initially(v(_), 7).\n",
                        "prim_action(a). prim_action(b). prim_action(c).\n",
                        "poss(a, true). poss(b, true). poss(c, true).\n"|Texts], Text),
    load_text(Text).

:- end_tests(open_effects).
