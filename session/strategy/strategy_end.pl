:- module(session_strategy_end,
          [ ended_by/4                  % +Error, +Session, +Situation, -End
          ]).
/** <module> What the run of a strategy ended by, in plain words with the place in its file

An error that the interpreter met in a step is the strategy's: what a server does wrong is met between steps.
*/

:- use_module('../display/display', [show/2]).
:- use_module('../display/ending_words', [error_text/2]).
:- use_module(impossible_actions, [blocked/4]).
:- use_module(named_actions, [no_settings/2, refused_action/3]).
:- use_module(strategy_file, [place_of/3]).
:- use_module('../../indigolog/indigolog', [fluent_value/3, situation_holds/2]).
:- use_module('../../indigolog/tools/explain', [why/3]).
:- use_module(library(apply), [maplist/2]).
:- use_module(library(lists), [member/2]).

%!  ended_by(+Error, +Session, +Situation, -End) is det.
%
%   End is finished, stopped(Signal) or failed(Error).

ended_by(stopped(Signal), _, _, End) =>
    End = stopped(Signal).
% A program that the strategy calls had the Ctrl-C.
ended_by(error(shell(signal(2), _), _), _, _, End) =>
    End = stopped(int).
% A strategy that would go on for ever comes to its end by the limit.
ended_by(error(golog(program_ended(failed, _, _)), _), Session, S, End),
        S \== none, \+ fluent_value(max_iterations, S, unknown), situation_holds(exhausted, S),
        fluent_value(candidate, S, none) =>
    fluent_value(max_iterations, S, Limit),
    show(Session.options, limit(Limit)),
    End = finished.
ended_by(Error, Session, S, End), Error = error(golog(program_ended(failed, Rest, _)), _), S \== none =>
    why(Rest, S, Whys),
    failed(Whys, Error, Session.plan.controller_file, S, End).
ended_by(error(golog(program_ended(aborted, _, _)), _), Session, _, End) =>
    place_of(Session.plan.controller_file, [abort], Place),
    wrong("~w: the strategy ended by `abort`; a session ends when its `control` does", [Place], End).
ended_by(Error, Session, _, End), refused_action(Error, Session.plan.controller_file, Message) =>
    End = failed(error(usage_error(Message), _)).
ended_by(error(golog(silent(Most)), golog(at(Rest, _), _)), Session, _, End) =>
    findall(Term, stands_at(Rest, Term), Terms),
    place_of(Session.plan.controller_file, Terms, Place),
    wrong("~w: the strategy made ~D steps without an action, and stands at ~W; does one of its loops never end?",
          [Place, Most, Rest, [quoted(true), max_depth(8)]], End).
ended_by(error(resource_error(_), Stack), Session, _, End), is_dict(Stack) =>
    out_of_memory(Stack, Session.plan.controller_file, End).
ended_by(error(usage_error(Message), _), _, _, End) =>
    End = failed(error(usage_error(Message), _)).           % of within_budget/3, which may ring in a step
ended_by(error(Formal, golog(world(Asked), Met)), Session, _, End) =>
    without_module(Met, Context),
    shown(Asked, Words),
    place_of(Session.plan.controller_file, [(Asked :- _), Asked], Place),
    error_text(error(Formal, Context), Text),
    wrong("~w: ~w came to an error: ~w", [Place, Words, Text], End).
ended_by(error(Formal, golog(at(Rest, _), Point)), Session, _, End) =>
    ( nonvar(Point), Point = point(Part, _, Met) -> true ; Part = Rest, Met = Point ),
    without_module(Met, Context),
    part_words(Part, Terms, Words),
    place_of(Session.plan.controller_file, Terms, Place),
    error_text(error(Formal, Context), Text),
    wrong("~w: ~w came to an error: ~w", [Place, Words, Text], End).
ended_by(Error, Session, _, End), Error \= error(_, _) =>
    place_of(Session.plan.controller_file, [throw(Error)], Place),
    wrong("~w: the strategy threw ~W", [Place, Error, [quoted(true), max_depth(8)]], End).
ended_by(Error, _, _, End) =>
    End = failed(Error).

wrong(Format, Arguments, failed(error(usage_error(Message), _))) :-
    format(string(Message), Format, Arguments).

failed(Whys, _, File, _, End) :-
    member(impossible(choose(Chosen), _), Whys),
    no_settings(Chosen, Words),
    !,
    place_of(File, [choose(Chosen), choose(_)], Place),
    wrong("~w: ~s", [Place, Words], End).
failed(Whys, _, File, S, End) :-
    member(impossible(Action, _), Whys),
    blocked(File, Action, S, Message),
    !,
    End = failed(error(usage_error(Message), _)).
failed(Whys, Error, File, _, End) :-
    findall(Term, ( member(Why, Whys), arg(1, Why, P), member(Term, [?(P), P]) ), Terms),
    place_of(File, Terms, Place),
    error_text(Error, Text),
    wrong("~w: ~w", [Place, Text], End).

%   stands_at(+Rest, -Term): what the first step of Rest may be in a file, a procedure before all else: in it is the loop.
stands_at(Rest, Term) :-
    ( is_list(Rest) -> Steps = Rest ; Steps = [Rest] ),
    (   member(Step, Steps), like(Step, Like), Term = proc(Like, _)
    ;   member(Term, Steps)
    ;   member(Step, Steps), like(Step, Term)
    ).

%   part_words(+Part, -Terms, -Words): of a part of the program; the first of Terms that is in a file is where it stands.
part_words([Part|_], Terms, Words) :-
    !,
    part_words(Part, Terms, Words).
part_words(Part, Terms, Words) :-
    (   tested(Part, P)
    ->  Shown = P,
        What = test
    ;   Shown = Part,
        What = step
    ),
    findall(Like, like(Shown, Like), Likes),
    Terms = [Part, Shown|Likes],
    shown(Shown, Text),
    format(string(Words), "the ~w ~s", [What, Text]).

shown(Term, Text) :-
    copy_term(Term, Nameless),
    term_variables(Nameless, Variables),
    maplist(=('$VAR'('_')), Variables),
    format(string(Text), "~W", [Nameless, [quoted(true), max_depth(8), numbervars(true)]]).

%   The module that a theory is loaded into has a name that says nothing.
without_module(Met, Context), nonvar(Met), Met = context(_:Indicator, Message) =>
    Context = context(Indicator, Message).
without_module(Met, Context) =>
    Context = Met.

tested(Part, P) :-
    nonvar(Part),
    member(Part, [?(P), if(P, _, _), while(P, _)]),
    !.

%   With other arguments: values have come in for names.
like(Term, Like) :-
    compound(Term),
    compound_name_arity(Term, Name, Arity),
    compound_name_arity(Like, Name, Arity).

%   Stack is what SWI-Prolog tells of the calls that were open.
out_of_memory(Stack, File, End) :-
    Megabytes is Stack.stack_limit // 1024,
    (   member(Key, [non_terminating, cycle]),
        member(frame(_, _:Goal, _), Stack.get(Key))
    ->  functor(Goal, Name, Arity),
        functor(Head, Name, Arity),
        place_of(File, [(Head :- _), Head], Place),
        wrong("~w: the strategy used up its memory, ~D MB, in ~q, ~D calls deep; does its recursion never end?",
              [Place, Megabytes, Name/Arity, Stack.depth], End)
    ;   wrong("~w: the strategy used up its memory, ~D MB, ~D calls deep; does one of its tests never end?",
              [File, Megabytes, Stack.depth], End)
    ).
