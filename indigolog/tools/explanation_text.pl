:- module(indigolog_explanation_text,
          [ explanations//1,          % +Whys
            shown_program/2           % +Program, -Shown
          ]).
/** <module> How the explanations of explain.pl read */

:- use_module(library(apply), [maplist/2, maplist/3]).
:- use_module('../language/semantics', [shown_as/2]).

:- multifile prolog:message//1.

prolog:message(golog(why([]))) -->
    [ 'There is nothing to explain: it is so'-[] ].
prolog:message(golog(why(Whys))) -->
    { Whys = [_|_] },
    explanations(Whys).

%!  shown_program(+Program, -Shown) is det.
%
%   Shown is Program with what only the interpreter writes put in the words of the language.

shown_program(E, Shown), \+ compound(E) =>
    Shown = E.
shown_program(E, Shown), shown_as(E, E1) =>
    shown_program(E1, Shown).
shown_program(E, Shown) =>
    compound_name_arguments(E, Name, Args),
    maplist(shown_program, Args, ShownArgs),
    compound_name_arguments(Shown, Name, ShownArgs).

%!  explanations(+Whys)// is det.
%
%   Message lines, parts indented below what they explain.

explanations(Whys) -->
    explanations(Whys, 0).

explanations([], _) --> [].
explanations([Why], Depth) -->
    !,
    explanation(Why, Depth).
explanations([Why|Whys], Depth) -->
    explanation(Why, Depth),
    [ nl ],
    explanations(Whys, Depth).

explanation(Why, Depth) -->
    { Columns is 2*Depth },
    [ '~*c'-[Columns, 0'\s] ],
    said(Why, Parts),
    below(Parts, Depth).

below([], _) --> [].
below([Part|Parts], Depth) -->
    [ nl ],
    { Deeper is Depth+1 },
    explanation(Part, Deeper),
    below(Parts, Depth).

%   nameless(+Term, -Shown): a variable that has no value is shown as such; Prolog's name for it says nothing.
nameless(Term, Shown) :-
    copy_term(Term, Shown),
    term_variables(Shown, Variables),
    maplist(=('$VAR'('_')), Variables).

said(false(P, Parts), Parts) -->
    { nameless(P, Shown) },
    [ '~p is false'-[Shown] ].
said(true(P, Parts), Parts) -->
    { nameless(P, Shown) },
    [ '~p is true'-[Shown] ].
said(value(F, unknown), []) -->
    !,
    { nameless(F, Shown) },
    [ '~p has no known value'-[Shown] ].
said(value(F, V), []) -->
    { nameless(F, Shown) },
    [ '~p = ~W'-[Shown, V, [quoted(true), portray(true), numbervars(true), max_depth(12)]] ].
said(impossible(A, Parts), Parts) -->
    { nameless(A, Shown) },
    [ 'action ~p is not possible'-[Shown] ],
    (   { ground(A) }
    ->  []
    ;   [ ': a variable in it has no value, as nothing before it gives it one'-[] ]
    ).
said(undeclared(A), []) -->
    [ '~p is neither an action nor a procedure of the theory'-[A] ].
said(not_an_instance(A), []) -->
    [ 'action ~p is not one of those that are declared'-[A] ].
said(no_axiom(A), []) -->
    [ 'action ~p has no precondition axiom'-[A] ].
said(no_plan(E, Event), []) -->
    { shown_program(E, Shown) },
    happened(Event),
    [ ', which the plan did not expect, and from there none is found for ~p'-[Shown] ].
said(no_step(E), []) -->
    { shown_program(E, Shown) },
    [ '~p has no step'-[Shown] ].
said(not_all(E), []) -->
    { shown_program(E, Shown) },
    [ 'not all of ~p was looked at: it goes too far'-[Shown] ].
said(apart(Offers), Offers) -->
    [ 'the programs of sync have no action in common'-[] ].
said(offer(E, As), []) -->
    { shown_program(E, Shown) },
    ( { As == [] } -> [ '~p can do nothing'-[Shown] ] ; [ '~p can do ~p'-[Shown, As] ] ).
said(no_result(A), []) -->
    [ 'the plan goes on with the sensing result of ~p, and there is none (offline nothing is sensed)'-[A] ].
said(dead_end([], Parts), Parts) -->
    [ 'at once:'-[] ].
said(dead_end([A|As], Parts), Parts) -->
    [ 'after ~p:'-[[A|As]] ].

happened(failed(A, Reason)) -->
    !,
    [ '~p failed ('-[A] ],
    '$messages':translate_message(error(Reason, _)),
    [ ')'-[] ].
happened(Event) -->
    [ '~p happened'-[Event] ].
