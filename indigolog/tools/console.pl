:- module(indigolog_console,
          [ step_through/2            % +Program, +Options
          ]).
/** <module> The stepper at the terminal: a command a line */

:- use_module(library(lists), [memberchk/2]).
:- use_module(library(readutil), [read_line_to_string/2]).
:- use_module(explanation_text, [explanations//1, shown_program/2]).
:- use_module(stepper).

%!  step_through(+Program, +Options) is det.
%
%   Read commands from user_input and answer them on user_output until `quit` or
%   the end of the input.  Options are those of start_stepper/3.

step_through(Program, Options) :-
    setup_call_cleanup(start_stepper(Program, Options, Stepper),
                       ( say(stepping(Program)),
                         converse(Stepper) ),
                       stop_stepper(Stepper)).

converse(Stepper) :-
    print_message(help, golog(prompt(step))),
    read_line_to_string(user_input, Line),
    (   Line == end_of_file
    ->  true
    ;   parsed(Line, Command)
    ->  (   Command == quit
        ->  true
        ;   obeyed(Command, Stepper, Stepper1),
            converse(Stepper1)
        )
    ;   say(no_command(Line)),
        converse(Stepper)
    ).

obeyed(Command, Stepper, Stepper1) :-
    catch(command(Command, Stepper, Stepper1, Answer), Error, true),
    (   var(Error)
    ->  say(Answer)
    ;   ( Error = error(golog(reported), _) -> true ; print_message(error, Error) ),
        Stepper1 = Stepper
    ).

say(Answer) :-
    phrase(answer(Answer), Lines),
    print_message_lines(user_output, '', Lines).

%   parsed(+Line, -Command): a word, or a word and a Prolog term.

parsed(Line, Command) :-
    split_string(Line, "", " \t\r", [Text]),
    (   Text == ""
    ->  Command = step
    ;   sub_string(Text, Before, 1, _, " ")
    ->  sub_string(Text, 0, Before, _, First),
        sub_string(Text, Before, _, 0, Rest),
        atom_string(Word, First),
        word(Word, Name),
        catch(term_string(Term, Rest), error(syntax_error(_), _), fail),
        Command =.. [Name, Term],
        known(Command)
    ;   atom_string(Word, Text),
        word(Word, Command),
        known(Command)
    ).

word(s, step).
word(r, run).
word(n, next).
word(f, fluents).
word(p, program).
word(h, history).
word(e, exog).
word(u, undo).
word(t, test).
word(w, why).
word(q, quit).
word(?, help).
word(Word, Word).

known(Command) :-
    memberchk(Command, [ step, run, next, fluents, fluents(_), program, history, exog(_), undo, test(_), why, why(_),
                         quit, help ]).
known(step(N)) :- integer(N), N >= 1.
known(run(N)) :- integer(N), N >= 1.

                /* Answers */

answer(stepping(E)) -->
    [ 'Stepping through ~p. Commands: ? lists them'-[E] ].
answer(no_command(Line)) -->
    [ '"~w" is not a command; ? lists them'-[Line] ].
answer(happened(Actions)) -->
    actions(Actions).
answer(ran(Actions, End)) -->
    actions(Actions),
    (   { End == none ; Actions == [] }
    ->  []
    ;   [ nl ]
    ),
    ( { End == none } -> [] ; answer(End) ).
answer(final) -->
    [ 'The program may end here'-[] ].
answer(waits) -->
    [ 'The program waits for an exogenous action: exog ACTION'-[] ].
answer(stuck(Whys)) -->
    [ 'The program has no step and may not end here'-[] ],
    because(Whys).
answer(next([], no)) -->
    [ 'Nothing: the program has no step and may not end here'-[] ].
answer(next([], may_end)) -->
    [ 'Nothing: the program may end here'-[] ].
answer(next_few(Actions, End)) -->
    (   { Actions == [] }
    ->  [ 'No step was found so far; step goes on looking'-[] ]
    ;   answer(next(Actions, End)),
        [ nl, 'and perhaps more'-[] ]
    ).
answer(next([A|As], End)) -->
    numbered([A|As], 1),
    (   { End == may_end }
    ->  [ nl, 'or the end'-[] ]
    ;   []
    ).
answer(no_such_step(N)) -->
    [ 'There is no ~D. possible action: next lists them'-[N] ].
answer(fluents([])) -->
    [ 'No fluent that matches has a value'-[] ].
answer(fluents([Pair|Pairs])) -->
    values([Pair|Pairs]).
answer(program(E)) -->
    { shown_program(E, Shown) },
    [ '~p'-[Shown] ].
answer(history([])) -->
    [ 'Nothing has happened'-[] ].
answer(history([A|As])) -->
    actions([A|As]).
answer(not_exogenous(A)) -->
    [ 'The theory declares no exogenous action ~p'-[A] ].
answer(nothing_to_undo) -->
    [ 'There is nothing to undo'-[] ].
answer(undone(N)) -->
    [ 'Back after ~D actions; what devices did stays done'-[N] ].
answer(holds(P)) -->
    [ '~p is true'-[P] ].
answer(why([])) -->
    [ 'There is nothing to explain: it is so'-[] ].
answer(why([Why|Whys])) -->
    explanations([Why|Whys]).
answer(help) -->
    [ 'step [N] (s, or an empty line)  the next action, or the N-th of those that can happen'-[], nl,
      'run [N] (r)                     steps until there is none, or N steps'-[], nl,
      'next (n)                        what can happen next'-[], nl,
      'fluents [F] (f)                 the values of fluents, or of those that match F, or have this name'-[], nl,
      'program (p)                     the program that remains'-[], nl,
      'history (h)                     what has happened'-[], nl,
      'exog ACTION (e)                 an exogenous action happens'-[], nl,
      'undo (u)                        take back the last step, run or exog'-[], nl,
      'test FORMULA (t)                is it true, and if not, why'-[], nl,
      'why [QUESTION] (w)              why there is no step; poss(A), holds(P), search(E) or a program'-[], nl,
      'quit (q)'-[] ].

because([]) --> [].
because([Why|Whys]) --> [ ':'-[], nl ], explanations([Why|Whys]).

actions([]) --> [].
actions([A]) --> !, [ '~q'-[A] ].
actions([A|As]) --> [ '~q'-[A], nl ], actions(As).

numbered([A], N) --> !, [ '~d  ~q'-[N, A] ].
numbered([A|As], N) --> [ '~d  ~q'-[N, A], nl ], { N1 is N+1 }, numbered(As, N1).

values([F-V]) --> !, [ '~q = ~q'-[F, V] ].
values([F-V|Pairs]) --> [ '~q = ~q'-[F, V], nl ], values(Pairs).
