:- module(indigolog_run, [main/0]).
:- use_module(library(lists), [reverse/2, member/2]).
:- use_module(indigolog).
:- use_module(checks, [check_theory/0, check_program/1]).
:- use_module(messages, []).

:- initialization(main, main).

/** <module> Run a Golog program of a theory file

    swipl indigolog/run.pl -- THEORY PROGRAM [--offline|--online] [--max-actions N]
*/

%!  main is det.
%
%   Run the command line and halt: 0 final, 1 failed or out of actions, 2 error.

main :-
    current_prolog_flag(argv, Argv0),
    (   Argv0 = ['--'|Argv] -> true ; Argv = Argv0 ),
    catch(run(Argv, Status), Error, failed(Error, Status)),
    halt(Status).

run(Argv, Status) :-
    arguments(Argv, options(offline, inf), Options, Words),
    (   Options == help
    ->  usage(Usage),
        format("~w~n", [Usage]),
        Status = 0
    ;   Words = [Theory, Text]
    ->  program(Text, Program),
        load_theory(Theory),
        known_program(Program),
        Options = options(Mode, Max),
        run(Mode, Program, Max, Status)
    ;   throw(usage('two arguments are needed, THEORY and PROGRAM'))
    ).

arguments([], Options, Options, []).
arguments([W|Ws], Options0, Options, Words) :-
    (   option_word(W, Ws, Options0, Options1, Ws1)
    ->  (   Options1 == help
        ->  Options = help, Words = []
        ;   arguments(Ws1, Options1, Options, Words)
        )
    ;   sub_atom(W, 0, _, _, '--')
    ->  format(atom(Message), 'unknown option ~w', [W]),
        throw(usage(Message))
    ;   Words = [W|Words1],
        arguments(Ws, Options0, Options, Words1)
    ).

option_word('--help', Ws, _, help, Ws).
option_word('-h', Ws, _, help, Ws).
option_word('--offline', Ws, options(_, Max), options(offline, Max), Ws).
option_word('--online', Ws, options(_, Max), options(online, Max), Ws).
option_word(W, Ws0, options(Mode, _), options(Mode, Max), Ws) :-
    (   W == '--max-actions'
    ->  ( Ws0 = [Text|Ws] -> true ; Text = '', Ws = [] )
    ;   atom_concat('--max-actions=', Text, W)
    ->  Ws = Ws0
    ),
    (   catch(atom_number(Text, Max), _, fail),
        integer(Max), Max >= 0
    ->  true
    ;   throw(usage('--max-actions needs a whole number'))
    ).

usage('usage: swipl indigolog/run.pl -- THEORY PROGRAM [--offline|--online] [--max-actions N]

Runs PROGRAM, a Golog program (one Prolog term, in quotes), of the theory file
THEORY. Executed actions are printed one a line, then "N actions.".

  --offline         find a complete execution before printing it (default)
  --online          execute step by step; without a device in the theory,
                    sensing and exogenous actions are asked for on the terminal
  --max-actions N   give up after N actions
  --help            this text

Exit status: 0 final, 1 the program failed or met --max-actions, 2 error.').

program(Text, Program) :-
    catch(term_to_atom(Program, Text), error(syntax_error(What), _),
          ( format(atom(Message), 'PROGRAM is not a Prolog term: ~w', [What]),
            throw(usage(Message)) )).

% The words of the program must be known before anything runs.
known_program(Program) :-
    check_theory,
    indigolog_checks:check_program(Program).

run(offline, Program, Max, Status) :-
    (   indigolog_offline:bounded_do(Program, Max, History, Limit),
        Limit \== true
    ->  printed(History),
        Status = 0
    ;   (   integer(Max)
        ->  say('no complete execution within ~w actions', [Max])
        ;   say('the program has no complete execution', [])
        ),
        Status = 1
    ).
run(online, Program, Max, Status) :-
    flag(indigolog_executed, _, 0),
    indigolog(Program, [ on_action(indigolog_run:print_action),
                         outcome(Outcome), max_actions(Max) ]),
    flag(indigolog_executed, N, N),
    format("~d actions.~n", [N]),
    (   Outcome == final
    ->  Status = 0
    ;   Outcome == limit
    ->  say('stopped after ~w actions', [Max]),
        Status = 1
    ;   say('the program ~w', [Outcome]),
        Status = 1
    ).

:- public print_action/2.

print_action(A, Situation) :-
    situation_history(Situation, [Newest|Before]),
    (   Newest = e(A, _), Before = [A|_]
    ->  Executed = true
    ;   indigolog_theory:current_theory(Theory),
        \+ ( indigolog_theory:action_template(Theory, A, exog),
             \+ indigolog_theory:action_template(Theory, A, prim) ),
        A \= failed(_, _)
    ->  Executed = true
    ;   Executed = false
    ),
    (   Executed == true
    ->  flag(indigolog_executed, N, N+1),
        format("~q~n", [A]),
        flush_output
    ;   true
    ).

printed(History) :-
    reverse(History, Actions),
    exclude_sensing(Actions, Executed),
    forall(member(A, Executed), format("~q~n", [A])),
    length(Executed, N),
    format("~d actions.~n", [N]).

exclude_sensing([], []).
exclude_sensing([A|As], Bs) :-
    (   ( A = e(_, _) ; A = test(_) ; A == wait )
    ->  Bs = Bs1
    ;   Bs = [A|Bs1]
    ),
    exclude_sensing(As, Bs1).

failed(usage(Message), 2) :-
    !,
    say('~w', [Message]),
    format(user_error, "~w~n", ['Try: swipl indigolog/run.pl -- --help']).
failed(stopped(_), 1) :-
    !,
    say('stopped', []).
failed(unwind(halt(Status)), Status) :-
    !.
failed(Error, 2) :-
    message_to_codes(Error).

message_to_codes(Error) :-
    (   Error = error(golog(reported), _)
    ->  true
    ;   message_text(Error, Text),
        format(user_error, "Error: ~w~n", [Text])
    ).

message_text(Error, Text) :-
    phrase(prolog:message(Error), Parts)
    ->  with_output_to(string(Text), print_message_lines(current_output, '', Parts))
    ;   message_to_lines(Error, Text).

message_to_lines(Error, Text) :-
    (   catch(phrase('$messages':translate_message(Error), Parts), _, fail)
    ->  with_output_to(string(Text), print_message_lines(current_output, '', Parts))
    ;   format(string(Text), "~p", [Error])
    ).

say(Format, Args) :-
    format(user_error, Format, Args),
    nl(user_error).
