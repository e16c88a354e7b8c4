:- module(indigolog_terminal,
          [ ask_execute/2,            % +Action, -Sensing
            ask_exog_occurs/1,        % -Action
            input_ended/0,
            forget_input_ended/0
          ]).

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

prompt_for(What, Answer) :-
    print_message(help, golog(prompt(What))),
    prompt(Old, ''),
    setup_call_cleanup(true,
                       read(user_input, Answer),
                       prompt(_, Old)).
