:- module(indigolog_semantics,
          [ trans/5,                  % +Program, +Situation, +Context, -Program1, -Situation1
            final/3,                  % +Program, +Situation, +Context
            never_final/1,            % +Program
            construct/2,              % ?Program, -Parts
            program_part/2,           % +Program, -Part
            shown_as/2,               % ?Program, -Shown
            step/4,                   % +Program, +Situation, -Program1, -Situation1
            may_end/2,                % +Program, +Situation
            construct_clause/2        % +Clause, -Defining
          ]).
/** <module> Trans and Final: the two relations that say what programs do

trans(E, S, C, E1, S1): program E in situation S may make a single step to program E1 in
situation S1.  final(E, S, C): E may legally end in S.  The rules are those of De Giacomo,
Lesperance and Levesque (2000).  Here are those of procedure calls and primitive actions;
every construct is defined in one place, by its clauses of the predicates that are
multifile here, under the rule that they state:

  - golog.pl        sequence, test, choice, if, while, star, pi
  - congolog.pl     concurrency, priorities, interrupts
  - extensions.pl, conditions.pl   what the published interpreter adds, and atomic
  - search/         search, plans that branch, achieve

In the rules E' and S' are trans's E1 and S1.  The context C is context.pl's.
*/

:- use_module(library(lists), [member/2]).
:- use_module(action, [act/3]).
:- use_module(context, [enter/3, enter_final/3, top_context/1]).
:- use_module(situation, [situation_history/2, situation_module/2]).

:- multifile
    trans_of/5,
    final_of/3,
    construct/2,
    is_construct/1,
    must_step/1,
    shown_as/2,
    error_place/5.
:- discontiguous
    trans_of/5,
    final_of/3,
    construct/2,
    is_construct/1,
    must_step/1.

%!  construct(?Program, -Parts) is nondet.
%
%   Program is a construct of the language; Parts are its program(E), programs(List),
%   formula(P) and variable(V), a variable, (V, Domain) or a list of these.

%!  shown_as(?Program, -Shown) is semidet.
%
%   Program is what a construct leaves between its steps, and not of the language; Shown is.

%!  construct_clause(+Clause, -Defining) is semidet.
%
%   Defining is Clause, which defines a construct and stands in a file of its own, as one of
%   this module: the expansion of terms in such a file.

construct_clause(construct(E, Parts), Clauses) :-
    construct_clause((construct(E, Parts) :- true), Clauses).
construct_clause((construct(E, Parts) :- Body), Clauses) :-
    functor(E, Name, Arity, Type),
    functor(G, Name, Arity, Type),
    Clauses = [ (indigolog_semantics:construct(E, Parts) :- Body),
                indigolog_semantics:is_construct(G) ].
construct_clause((Head0 => Body), (indigolog_semantics:Head => Body)) :-
    defining(Head0, Head).
construct_clause((Head0 :- Body), (indigolog_semantics:Head :- Body)) :-
    defining(Head0, Head).
construct_clause(Head0, indigolog_semantics:Head) :-
    defining(Head0, Head).

defining(trans(E, S, C, E1, S1), trans_of(E, S, C, E1, S1)).
defining(final(E, S, C), final_of(E, S, C)).
defining(must_step(E), must_step(E)).
defining(shown_as(E, Shown), shown_as(E, Shown)).

%!  trans(+Program, +Situation, +Context, -Program1, -Situation1) is nondet.
%
%   @error golog(open_program) if Program is unbound

% Trans(P(t), S, E', S')  <=>  Trans(Body(t), S, E', S'), for a procedure P(v) with Body
% Trans(a, S, E', S')     <=>  Poss(a[S], S) & E' = [] & S' = do(a[S], S)
trans(E, S, C, E1, S1) :-
    (   var(E)
    ->  throw(error(golog(open_program), _))
    ;   is_construct(E)
    ->  trans_of(E, S, C, E1, S1)
    ;   situation_module(S, Module),
        Module:proc(E, Body)
    ->  enter(E, C, C1),
        trans(Body, S, C1, E1, S1)
    ;   E1 = [],
        act(E, S, S1)
    ).

%!  final(+Program, +Situation, +Context) is nondet.
%
%   Nondeterministic only for programs with free variables.

% Final(P(t), S)  <=>  Final(Body(t), S)
% Final(a, S)     <=>  False
final(E, S, C) :-
    (   var(E)
    ->  throw(error(golog(open_program), _))
    ;   is_construct(E)
    ->  final_of(E, S, C)
    ;   situation_module(S, Module),
        Module:proc(E, Body)
    ->  \+ never_final(Body),
        enter_final(E, C, C1),
        final(Body, S, C1)
    ).

%!  never_final(+Program) is semidet.
%
%   Program has no final situation whatever the theory says: it must make a step first.
%   Lets a sequence go on without a choice point.

never_final(E) :-
    nonvar(E),
    must_step(E),
    !.

%!  program_part(+Program, -Part) is nondet.
%
%   Part is a program that the construct Program is made of.

program_part(E, Part) :-
    construct(E, Parts),
    (   member(program(Part), Parts)
    ;   member(programs(Es), Parts),
        is_list(Es),
        member(Part, Es)
    ).

%!  step(+Program, +Situation, -Program1, -Situation1) is nondet.
%
%   A step from the top: errors are told with the program and the situation.

step(E, S, E1, S1) :-
    top_context(C),
    catch(trans(E, S, C, E1, S1), Error, in_step(Error, E, S)).

%!  may_end(+Program, +Situation) is semidet.
%
%   Program is final, seen from the top: errors are told as those of a step.

may_end(E, S) :-
    top_context(C),
    catch(final(E, S, C), Error, in_step(Error, E, S)),
    !.

% Rethrow Error with the program and the history it was met in, and where in the program
% if error_place(+Formal, +Program, +Situation, -Point, -Bindings) is there to tell.
in_step(Error, E, S) :-
    (   Error = error(Formal, Context),
        \+ is_dict(Context),              % of a stack overflow
        \+ subsumes_term(golog(_, _), Context)
    ->  situation_history(S, History),
        (   error_place(Formal, E, S, Point, Bindings)
        ->  true
        ;   Point = E, Bindings = []
        ),
        own_words(Formal, Context, S, Told, Context1),
        throw(error(Told, golog(at(E, History), point(Point, Bindings, Context1))))
    ;   throw(Error)
    ).

% A test that calls a predicate which the theory does not have.
own_words(Formal, Context, S, Told, Context1) :-
    (   Formal = existence_error(procedure, Module:PI),
        situation_module(S, Module)
    ->  Told = golog(unknown_formula(PI))
    ;   Told = Formal, Context1 = Context
    ).
