:- module(indigolog_terminal,
          [ ask_execute/2,            % +Action, -Sensing
            ask_exog_occurs/1,        % -Action
            input_ended/0,
            forget_input_ended/0
          ]).

:- use_module(library(readutil), [read_line_to_string/2]).

/** <module> The terminal as the world

What a person at the terminal answers stands for sensing results and exogenous
actions.  Prompts go to the error stream, so that standard output keeps only
the executed actions.
*/

%!  ask_execute(+Action, -Sensing) is det.
%
%   Ask for the sensing result of Action if the current theory has a sensing
%   axiom for it; any other action just counts as done.

ask_execute(Action, Sensing) :-
    (   indigolog_situation:sensing_action(Action)
    ->  prompt_for(sensing(Action), Sensing),
        (   Sensing == end_of_file
        ->  throw(error(golog(no_answer(Action)), _))
        ;   true
        )
    ;   true
    ).

%!  ask_exog_occurs(-Action) is semidet.
%
%   Ask for an exogenous action; `nil`, or the end of input, means none.

ask_exog_occurs(Action) :-
    prompt_for(exogenous, Answer),
    (   Answer == end_of_file
    ->  nb_setval(indigolog_input_ended, true),
        fail
    ;   true
    ),
    Answer \== nil,
    Action = Answer.

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
