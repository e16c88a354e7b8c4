:- module(indigolog_terminal,
          [ ask_execute/2,            % +Action, -Sensing
            ask_in/2,                 % +Situation, :Goal
            ask_exog_occurs/1,        % -Action
            input_ended/0,
            forget_input_ended/0
          ]).
/** <module> The terminal as the world

What a person at the terminal answers stands for sensing results and exogenous
actions.  Prompts go to the error stream, so that standard output keeps only
the executed actions.
*/

:- use_module(library(lists), [memberchk/2]).
:- use_module(library(readutil), [read_line_to_string/2]).
:- use_module('../language/sensing', [answers/3, sensing_action/1]).

:- meta_predicate ask_in(+, 0).

:- multifile indigolog_loading:theories_may_call/1.

indigolog_loading:theories_may_call(indigolog_terminal:ask_execute/2).
indigolog_loading:theories_may_call(indigolog_terminal:ask_exog_occurs/1).

%!  ask_execute(+Action, -Sensing) is det.
%
%   Ask for the sensing result of Action if the current theory has a sensing
%   axiom for it; any other action just counts as done.

ask_execute(Action, Sensing) :-
    (   sensing_action(Action)
    ->  results(Action, Results),
        answer(Action, Results, Sensing)
    ;   true
    ).

answer(Action, Results, Sensing) :-
    prompt_for(sensing(Action, Results), Answer),
    (   Answer == end_of_file
    ->  throw(error(golog(no_answer(Action)), _))
    ;   \+ ground(Answer)
    ->  print_message(error, golog(open_answer(Answer))),
        answer(Action, Results, Sensing)
    ;   ( Results == [] ; memberchk(Answer, Results) )
    ->  Sensing = Answer
    ;   print_message(error, golog(no_answer_of(Answer, Results))),
        answer(Action, Results, Sensing)
    ).

% What may be answered, where it can be told.
results(Action, Results) :-
    (   nb_current(indigolog_asked_in, S),
        S \== none,
        answers(Action, S, Results0)
    ->  Results = Results0
    ;   Results = []
    ).

%!  ask_in(+Situation, :Goal) is nondet.
%
%   Call Goal, which may execute an action that led to Situation: the question for its
%   sensing result then tells what may be answered there.

ask_in(S, Goal) :-
    ( nb_current(indigolog_asked_in, Before) -> true ; Before = none ),
    b_setval(indigolog_asked_in, S),
    call(Goal),
    b_setval(indigolog_asked_in, Before).

%!  ask_exog_occurs(-Action) is semidet.
%
%   Ask for an exogenous action; `nil`, or the end of input, means none.

ask_exog_occurs(Action) :-
    prompt_for(exogenous, Answer),
    (   Answer == end_of_file
    ->  nb_setval(indigolog_input_ended, true),
        fail
    ;   ground(Answer)
    ->  Answer \== nil,
        Action = Answer
    ;   print_message(error, golog(open_answer(Answer))),
        ask_exog_occurs(Action)
    ).

%!  input_ended is semidet.
%
%   The end of the input was met where an exogenous action was asked for.

input_ended :-
    nb_current(indigolog_input_ended, true).

%!  forget_input_ended is det.

forget_input_ended :-
    nb_setval(indigolog_input_ended, false).

% A term, with or without a full stop, on as many lines as it takes.
prompt_for(What, Answer) :-
    print_message(help, golog(prompt(What))),
    prompt(Old, ''),
    call_cleanup(read_answer("", Answer0), prompt(_, Old)),
    (   Answer0 = term(Answer)
    ->  true
    ;   print_message(error, golog(no_term(Answer0))),
        prompt_for(What, Answer)
    ).

read_answer(Before, Answer) :-
    read_line_to_string(user_input, Line),
    (   Line == end_of_file
    ->  Answer = term(end_of_file)
    ;   atomics_to_string([Before, Line, "\n"], Text),
        split_string(Text, "", " \t\r\n", [Trimmed]),
        (   Trimmed == ""
        ->  read_answer("", Answer)
        ;   catch(term_string(Term, Trimmed), error(syntax_error(_), _), fail)
        ->  Answer = term(Term)
        ;   sub_string(Trimmed, _, 1, 0, ".")
        ->  Answer = Trimmed
        ;   read_answer(Text, Answer)
        )
    ).
