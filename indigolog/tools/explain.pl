:- module(indigolog_explain,
          [ why/3                     % +Question, +Situation, -Whys
          ]).
/** <module> Why something is not so

A Why is one of

    false(Formula, Parts)           % Formula is false, because of Parts
    true(Formula, Parts)            % Formula is true, where it should not be
    value(Fluent, Value)            % `unknown` for a fluent without a value
    impossible(Action, Parts)
    undeclared(Action)              % neither an action nor a procedure
    not_an_instance(Action)         % of a declared action
    no_axiom(Action)                % no precondition axiom
    stopped(Interrupt)              % waits for interrupts to run
    no_result(Action)               % a plan goes on with its sensing result
    no_plan(Program, Event)         % a plan was not made for Event, and what is left of Program has none
    apart(Offers)                   % programs of sync/1 with no action in common; Offers are offer(Program, Actions)
    no_step(Program)                % anything else
    not_all(Program)                % there may be more: looking for it was given up
    dead_end(Actions, Whys)         % a way that does not lead to the end

and is printed by explanations//1 of explanation_text.pl.
*/

:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, reverse/2]).
:- use_module(library(solution_sequences), [limit/2]).
:- use_module('../language/action', [pick/5]).
:- use_module('../language/configuration', [after_action/5, ends/3]).
:- use_module('../language/congolog', [by_priority/2]).
:- use_module('../language/context', [top_context/1]).
:- use_module('../language/extensions', [for_sequence/5]).
:- use_module('../language/formula', [evaluate/3, holds_in/2]).
:- use_module('../language/semantics').
:- use_module('../language/situation').
:- use_module('../language/theory').
:- use_module('../search/monitor', [unplanned/4]).
:- use_module('../search/memory', [new_memory/4, seen/4]).
:- use_module(effort, [found_within/5]).
:- use_module(why_false).

% Most dead ends that are told of, and configurations that are looked at for them; chosen by hand.
most_dead_ends(20).
most_configurations(10_000).

% What looking for an explanation may cost.
most_inferences(2_000_000).

%!  why(+Question, +Situation, -Whys) is det.
%
%   Question is poss(Action), holds(Formula), search(Program) or a program.  Whys
%   is empty where there is nothing to explain.

why(poss(A), S, Whys) =>
    findall(Why, why_not_possible(A, S, Why), Whys).
why(holds(P), S, Whys) =>
    findall(Why, why_false(P, S, Why), Whys).
why(search(E), S, Whys) =>
    top_context(C),
    bounded(search(E), Why, dead_end(E, S, C, Why), Whys).
why(E, S, Whys) =>
    why_stuck(E, S, Whys).

:- meta_predicate bounded(+, ?, 0, -).

bounded(E, Why, Goal, Whys) :-
    most_inferences(Limit),
    found_within(Limit, Why, Goal, Whys0, Whole),
    ( Whole == true -> Whys = Whys0 ; append(Whys0, [not_all(E)], Whys) ).


                /* Actions */

% why_not_possible(+Action, +Situation, -Why) is semidet: fails if Action is
% possible.

why_not_possible(A, S, Why) :-
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   \+ action_template(Theory, A, _)
    ->  Why = undeclared(A)
    ;   \+ Module:prim_action(A)
    ->  Why = not_an_instance(A)
    ;   \+ Module:poss(A, _)
    ->  Why = no_axiom(A)
    ;   \+ ( Module:poss(A, P), is_true(P, S) ),
        findall(P, Module:poss(A, P), Ps),
        whys_false(Ps, S, Parts),
        Why = impossible(A, Parts)
    ).


                /* Programs */

% why_stuck(+Program, +Situation, -Whys) is det.
%
%   What stands in the way of each of the ways to begin Program.

why_stuck(E, S, Whys) :-
    top_context(C),
    most(Most),
    bounded(E, Why, limit(Most, blocked(E, S, C, Why)), Whys0),
    sort(0, @<, Whys0, Whys).

% blocked(+E, +S, +C, -Why) is nondet: one Why for each way to begin.

blocked(E, _, _, Why), var(E) =>
    Why = no_step(E).
blocked([], _, _, _) =>
    fail.
blocked([E|L], S, C, Why) =>
    (   trans(E, S, C, E1, S1)
    *-> same_situation(S, S1),
        ( E1 == [] -> Next = L ; Next = [E1|L] ),
        blocked(Next, S1, C, Why)
    ;   final(E, S, C)
    *-> blocked(L, S, C, Why)
    ;   blocked(E, S, C, Why)
    ).
blocked(E, S, C, Why), unplanned(E, S, C, Left) =>
    last_action(S, Event),
    Why = no_plan(Left, Event).
blocked(E, S, C, Why), shown_as(E, E0) =>
    blocked(E0, S, C, Why).
blocked(stop_interrupts, _, _, _) =>
    fail.
blocked(?(P), S, _, Why) =>
    why_false(P, S, Why).
blocked(??(P), S, _, Why) =>
    why_false(P, S, Why).
blocked(if(P, E), S, C, Why) =>
    blocked(if(P, E, ?(P)), S, C, Why).
blocked(if(P, E, F), S, C, Why) =>
    (   holds_in(P, S)
    ->  blocked(E, S, C, Why)
    ;   blocked(F, S, C, Why)
    ).
blocked(while(P, E), S, C, Why) =>
    (   holds_in(P, S)
    *-> blocked(E, S, C, Why)
    ;   why_false(P, S, Why)
    ).
blocked(pi(V, E), S, C, Why) =>
    pick(V, E, listed, S, E1),
    blocked(E1, S, C, Why).
blocked(pi(V, D, E), S, C, Why) =>
    blocked(pi((V, D), E), S, C, Why).
blocked(for(V, D, E), S, C, Why) =>
    for_sequence(V, D, E, S, Es),
    blocked(Es, S, C, Why).
blocked(interrupt(P, E), S, C, Why) =>
    (   holds_in(P, S)
    ->  blocked(E, S, C, Why)
    ;   why_false(P, S, Why)
    ).
blocked(prioritized_interrupts(Is), S, C, Why) =>
    by_priority(Is, E),
    blocked(E, S, C, Why).
blocked(case(A, _), S, _, Why), \+ ( situation_history(S, H), memberchk(e(A, _), H) ) =>
    Why = no_result(A).
blocked(gexec(P, E), S, C, Why) =>
    (   holds_in(P, S)
    ->  blocked(E, S, C, Why)
    ;   why_false(P, S, Why)
    ).
blocked(search(E, _), S, C, Why) =>
    blocked(search(E), S, C, Why).
blocked(search(E), S, C, Why) =>
    dead_end(E, S, C, Why).
blocked(rpi(V, E), S, C, Why) =>
    blocked(pi(V, E), S, C, Why).
blocked(rpi(V, D, E), S, C, Why) =>
    blocked(pi((V, D), E), S, C, Why).
blocked(interrupt(V, P, E), S, C, Why) =>
    blocked(pi(V, if(P, E)), S, C, Why).
blocked(sync([E|Es]), S, C, Why) =>
    maplist(offer(S, C), [E|Es], Offers),
    (   member(offer(Idle, []), Offers),
        blocked(Idle, S, C, Why)
    *-> true
    ;   \+ ( Offers = [offer(_, As)|Others],
             member(A, As),
             \+ ( member(offer(_, Bs), Others), \+ memberchk(A, Bs) ) ),
        Why = apart(Offers)
    ).
blocked(goal(_, E, _, _), S, C, Why) =>
    blocked(E, S, C, Why).
blocked(E, S, C, Why), construct(E, _), \+ plans(E), program_part(E, _) =>
    program_part(E, Part),                % stuck only where all its parts are
    blocked(Part, S, C, Why).
blocked(E, S, C, Why), construct(E, _) =>
    \+ trans(E, S, C, _, _),
    Why = no_step(E).
blocked(E, S, C, Why) =>
    situation_theory(S, Theory),
    theory_module(Theory, Module),
    (   Module:proc(E, Body)
    ->  blocked(Body, S, C, Why)
    ;   callable(E),
        evaluated(E, S, A),
        why_not_possible(A, S, Why)
    ).

% offer(+Situation, +Context, +Program, -Offer): the actions that Program can come to.
offer(S, C, E, offer(E, As)) :-
    findall(A, ( after_action(E, S, C, _, S1), last_action(S1, A) ), As0),
    sort(As0, As).

% Of these it is only said that they have no step.
plans(searchc(_)).
plans(searchc(_, _)).
plans(case(_, _)).

evaluated(E, S, A) :-
    E =.. [Name|Args0],
    maplist(evaluated_argument(S), Args0, Args),
    A =.. [Name|Args].

evaluated_argument(S, Arg, Value) :-
    (   catch(evaluate(Arg, S, Value0), error(_, _), fail)
    ->  Value = Value0
    ;   Value = Arg
    ).

% dead_end(+Program, +Situation, +Context, -Why) is nondet: the ways to execute
% Program that lead nowhere, in the order of depth first search, up to the first
% that leads to the end: dead_end(Actions, Whys), with what was in the way after
% Actions.

dead_end(E, S, C, Why) :-
    new_memory(E, S, [], Memory),
    most_dead_ends(Most),
    most_configurations(Configurations),
    State = state(Configurations),
    findall(End, limit(Most, way(E, S, C, [], Memory, State, End)), Ends0),
    before_end(Ends0, Ends),
    member(Why, Ends).

before_end([], []).
before_end([End|More], Ends) :-
    (   End == end
    ->  Ends = []
    ;   Ends = [End|Ends1],
        before_end(More, Ends1)
    ).

way(E, S, C, Done, Memory, State, End) :-
    arg(1, State, Left),
    Left > 0,
    Left1 is Left-1,
    nb_setarg(1, State, Left1),
    \+ seen(Memory, E, S, 0),
    (   ends(E, S, C)
    ->  End = end
    ;   after_action(E, S, C, E1, S1)
    *-> last_action(S1, A),
        way(E1, S1, C, [A|Done], Memory, State, End)
    ;   reverse(Done, Actions),
        findall(Why, blocked(E, S, C, Why), Whys0),
        sort(0, @<, Whys0, Whys),
        End = dead_end(Actions, Whys)
    ).
