:- module(indigolog_knowledge,
          [ known/2,                  % +Formula, +Situation
            known_whether/2           % +Formula, +Situation
          ]).
:- use_module(formula, [holds/2]).

/** <module> What the agent knows */

%!  known(+Formula, +Situation) is nondet.
known(P, S) :-
    holds(P, S).

%!  known_whether(+Formula, +Situation) is semidet.
known_whether(P, S) :-
    (   known(P, S)
    ;   known(neg(P), S)
    ),
    !.
