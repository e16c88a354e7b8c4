:- module(test_indigolog_compiled, []).
:- use_module(library(plunit)).
:- use_module(library(random), [random_between/3, random_member/2]).
:- use_module('../../indigolog/indigolog').
:- use_module('../../indigolog/language/formula', [true_in/2]).
:- use_module('../../indigolog/language/history', [history_situation/2]).
:- use_module('../../indigolog/language/theory', [current_theory/1, theory_module/2]).

/** <module> Axioms that are compiled when a theory is loaded mean what formulas mean

formula.pl defines formulas, compiled.pl unfolds the definition: for random formulas over the
arguments of an action the compiled precondition must be true where the formula is.
*/

formulas(300).

base("fun_fluent(n). fun_fluent(v(I)) :- member(I, [1, 2, 3]). rel_fluent(lit(I)) :- member(I, [1, 2, 3]).
      initially(n, 1). initially(v(1), 2). initially(v(2), 3). initially(v(3), 1).
      initially(lit(I), B) :- member(I-B, [1-true, 2-false, 3-true]).
      proc(both(X, Y), and(lit(X), lit(Y))). proc(some_lit, some((k, [1, 2, 3]), lit(k))).
      cells([1, 2, 3]). small(I) :- I < 3.
      prim_action(set_n(I)) :- member(I, [1, 2, 3]). poss(set_n(_), true). causes_val(set_n(I), n, I, true).
      prim_action(flip(I)) :- member(I, [1, 2, 3]). poss(flip(_), true).
      causes_true(flip(I), lit(I), neg(lit(I))). causes_false(flip(I), lit(I), lit(I)).\n").

% random_formula(+Depth, +Terms, -Formula): Terms are what may stand for a number.
random_formula(0, Terms, P) :-
    !,
    random_member(T1, Terms),
    random_member(T2, Terms),
    random_member(P, [ T1 = T2, T1 < T2, T1 >= T2, T1 =:= T2, lit(T1), lit(T2), both(T1, T2), some_lit,
                       small(T1), true, false, done(set_n(T1)), know(lit(T1)), v(T1) = T2, n = T1 ]).
random_formula(N, Terms, P) :-
    M is N-1,
    random_formula(M, Terms, P1),
    random_formula(M, Terms, P2),
    random_formula(M, [Z, k|Terms], P3),
    random_member(P, [ and(P1, P2), or(P1, P2), neg(P1), and([P1, P2]), or([P1, P2]), and([]), or([]), (P1, P2),
                       (P1 ; P2), \+ P1, (P1 -> P2), (P1 -> P2 ; P1), impl(P1, P2), equiv(P1, P2), once(P1),
                       forall(P1, P2), some([(Z, [1, 2]), (k, cells)], P3), all([(Z, [1, 2]), (k, cells)], P3),
                       some((Z, cells), some(k, [1, 3], P3)), some(W, and(W = v(1), small(W))) ]).

load_formulas(Count) :-
    base(Base),
    findall(I-(X-Y-P),
            ( between(1, Count, I),
              random_between(0, 3, Depth),
              random_formula(Depth, [X, Y, 1, 2, n, v(X)], P) ),
            Formulas),
    setup_call_cleanup(
        tmp_file_stream(text, File, Out),
        ( format(Out, "~s", [Base]),
          format(Out, "prim_action(a(I, X, Y)) :- between(1, ~d, I), member(X, [1, 2, 3]), member(Y, [1, 2, 3]).~n", [Count]),
          forall(member(I-(X-Y-P), Formulas),
                 format(Out, "~k.~n", [poss(a(I, X, Y), P)])),
          close(Out),
          load_theory(File) ),
        delete_file(File)).

differs(I, X, Y, H) :-
    current_theory(Theory),
    theory_module(Theory, Module),
    member(H, [[], [flip(1)], [set_n(3), flip(2), flip(1)]]),
    history_situation(H, S),
    Module:prim_action(a(I, X, Y)),
    truth(Module:'$possible'(a(I, X, Y), S), Compiled),
    truth(( Module:poss(a(I, X, Y), P), true_in(P, S) ), Defined),
    Compiled \== Defined.

truth(Goal, Truth) :-
    catch(( call(Goal) -> Truth = true ; Truth = false ), error(Formal, _), ( functor(Formal, Name, _), Truth = Name )).

:- begin_tests(compiled_formulas).

test(compiled_as_defined, true) :-
    formulas(Count),
    load_formulas(Count),
    (   differs(I, X, Y, H)
    ->  current_theory(Theory),
        theory_module(Theory, Module),
        clause(Module:poss(a(I, X, Y), P), _),
        print_message(error, format("~p differs after ~p", [P, H])),
        fail
    ;   true
    ).

:- end_tests(compiled_formulas).
