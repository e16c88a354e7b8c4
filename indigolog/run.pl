:- module(indigolog_run, [main/0]).
/** <module> Run a Golog program of a theory file

    swipl indigolog/run.pl -- THEORY PROGRAM [--offline|--online|--step] [OPTION...]
*/

:- use_module(library(apply), [exclude/3]).
:- use_module(library(debug), [debug/1]).
:- use_module(library(lists), [reverse/2, member/2, memberchk/2]).
:- use_module(library(option), [option/2, option/3]).
:- autoload(library(readutil), [read_file_to_terms/3]).
:- use_module(indigolog).
:- use_module(tools/checks, [check_theory/0, check_program/1]).
:- use_module(tools/console, [step_through/2]).
:- use_module(tools/explain, [why/3]).
:- use_module(tools/explanation_text, [explanations//1]).
:- use_module(language/history, [own_step/1]).
:- use_module(language/offline, [bounded_do/4]).
:- use_module(language/patience, [with_patience/2]).
:- use_module(language/situation, [initial_situation/1]).

:- initialization(main, main).

%!  main is det.
%
%   Run the command line and halt: 0 final, 1 failed or out of actions, 2 error.

main :-
    current_prolog_flag(argv, Argv0),
    (   Argv0 = ['--'|Argv] -> true ; Argv = Argv0 ),
    catch(run(Argv, Status), Error, failed(Error, Argv, Status)),
    halt(Status).

run(Argv, Status) :-
    arguments(Argv, Options, Words),
    (   option(help(true), Options)
    ->  usage(Usage),
        format("~w~n", [Usage]),
        Status = 0
    ;   option(version(true), Options)
    ->  version(Version),
        format("indigolog ~w~n", [Version]),
        Status = 0
    ;   Words = [Theory, Text]
    ->  program(Text, Program),
        catch(load_theory(Theory), error(existence_error(source_sink, Theory), _), throw(no_theory(Theory))),
        known_program(Program),
        (   option(trace(true), Options)
        ->  debug(indigolog)
        ;   true
        ),
        mode(Options, Mode),
        run(Mode, Program, Options, Status)
    ;   throw(usage('two arguments are needed after --, THEORY and PROGRAM'))
    ).

% As the pack says it, beside this file.
version(Version) :-
    module_property(indigolog_run, file(File)),
    file_directory_name(File, Folder),
    atom_concat(Folder, '/pack.pl', Pack),
    read_file_to_terms(Pack, Terms, []),
    memberchk(version(Version), Terms).

% The last of --offline, --online and --step counts; a journal has only an online run.
mode(Options, Mode) :-
    (   option(mode(Mode0), Options)
    ->  Mode = Mode0
    ;   member(Option, [journal(_), resume(_), replay(_)]),
        option(Option, Options)
    ->  Mode = online
    ;   Mode = offline
    ).

arguments(Argv, Options, Words) :-
    arguments(Argv, [], Options, Words).

arguments([], Options, Options, []).
arguments([W|Ws], Options0, Options, Words) :-
    (   option_word(W, Option)
    ->  arguments(Ws, [Option|Options0], Options, Words)
    ;   value_word(W, Ws, Ws1, Flag, Text)
    ->  (   option_value(Flag, Text, Option)
        ->  arguments(Ws1, [Option|Options0], Options, Words)
        ;   value_option(Flag, _, What),
            format(atom(Message), '~w needs ~w', [Flag, What]),
            throw(usage(Message))
        )
    ;   sub_atom(W, 0, _, _, '--')
    ->  format(atom(Message), 'unknown option ~w', [W]),
        throw(usage(Message))
    ;   Words = [W|Words1],
        arguments(Ws, Options0, Options, Words1)
    ).

option_word('--help', help(true)).
option_word('-h', help(true)).
option_word('--version', version(true)).
option_word('--offline', mode(offline)).
option_word('--online', mode(online)).
option_word('--step', mode(step)).
option_word('--explain', explain(true)).
option_word('--trace', trace(true)).

% --flag VALUE or --flag=VALUE
value_word(W, Ws0, Ws, Flag, Text) :-
    value_option(Flag, _, _),
    (   W == Flag
    ->  ( Ws0 = [Text|Ws] -> true ; Text = '', Ws = [] )
    ;   atomic_list_concat([Flag, '='], Start),
        atom_concat(Start, Text, W),
        Ws = Ws0
    ),
    !.

value_option('--max-actions', max_actions, 'a whole number from 0').
value_option('--max-silent', max_silent, 'a whole number from 0').
value_option('--max-wait', max_wait, 'a number of seconds from 0').
value_option('--seed', seed, 'a whole number from 0').
value_option('--journal', journal, 'a file').
value_option('--resume', resume, 'a file').
value_option('--replay', replay, 'a file').

option_value(Flag, Text, Option) :-
    value_option(Flag, Name, What),
    value(What, Text, Value),
    Option =.. [Name, Value].

value('a file', File, File) :-
    File \== ''.
value('a number of seconds from 0', Text, Seconds) :-
    catch(atom_number(Text, Seconds), _, fail),
    Seconds >= 0,
    Seconds < inf.
value('a whole number from 0', Text, N) :-
    catch(atom_number(Text, N), _, fail),
    integer(N), N >= 0.

usage('usage: swipl indigolog/run.pl -- THEORY PROGRAM
             [--offline|--online|--step] [OPTION...]

Runs PROGRAM, a Golog program (one Prolog term, in quotes), of the theory file
THEORY. Executed actions are printed one a line, then "N actions.".

  --offline         find a complete execution before printing it (default)
  --online          execute step by step; without execute/2 and exog_occurs/1 in
                    the theory, sensing results, and exogenous actions where the
                    program waits for one, are asked for on the terminal
  --step            step through the program by hand; ? lists the commands
  --max-actions N   give up after N actions
  --max-silent N    an error after N steps without an action (100000)
  --max-wait S      an error when no exogenous action has arrived for S seconds,
                    online
  --explain         say what was in the way when there is no complete execution
  --trace           say on stderr what happens and what plans search finds
  --seed N          of random choices, online
  --journal FILE    write a fact an action, online; FILE is new or empty
  --resume FILE     go on after what that journal tells, and write to it
  --replay FILE     follow that journal, and do nothing more
  --help            this text
  --version         print the version

Exit status: 0 final, 1 the program failed or met --max-actions, 2 error.').

program(Text, Program) :-
    catch(term_to_atom(Program, Text), error(syntax_error(What), _),
          ( syntax_words(What, Words),
            format(atom(Message), 'PROGRAM is not a Prolog term: ~w', [Words]),
            throw(usage(Message)) )),
    (   Program == end_of_file
    ->  throw(usage('PROGRAM is empty'))
    ;   after_term(Text, Rest),
        catch(term_string(end_of_file, Rest), error(syntax_error(_), _), fail)
    ->  true
    ;   throw(usage('PROGRAM is not one Prolog term: something follows its end'))
    ).

% after_term(+Text, -Rest): what follows the term that Text begins with, which may be without an end of its own.
after_term(Text, Rest) :-
    End = "\n.",
    string_concat(Text, End, Ended),
    setup_call_cleanup(open_string(Ended, Stream),
                       ( read_term(Stream, _, []),
                         read_string(Stream, _, Left) ),
                       close(Stream)),
    ( string_concat(Rest0, End, Left) -> Rest = Rest0 ; Rest = "" ).

syntax_words(end_of_clause, Words) =>
    Words = 'it ends too early'.
syntax_words(What, Words) =>
    format(atom(Quoted), '~w', [What]),
    atomic_list_concat(Parts, '_', Quoted),
    atomic_list_concat(Parts, ' ', Words).

% The words of the program must be known before anything runs.
known_program(Program) :-
    check_theory,
    check_program(Program).

run(offline, Program, Options, Status) :-
    option(max_actions(Max), Options, inf),
    option(max_silent(Silent), Options, default),
    (   with_patience(Silent, bounded_do(Program, Max, History, Limit)),
        Limit \== true
    ->  printed(History),
        ( History = [abort|_] -> Outcome = aborted ; Outcome = final ),
        ended(Outcome, Options, [], none, Status)
    ;   (   integer(Max)
        ->  say('no complete execution within ~w actions', [Max])
        ;   say('the program has no complete execution', [])
        ),
        (   option(explain(true), Options)
        ->  initial_situation(S),
            explained(search(Program), S)
        ;   say('(--explain tells what was in the way)', [])
        ),
        Status = 1
    ).
run(online, Program, Options, Status) :-
    flag(indigolog_executed, _, 0),
    findall(Option, online_option(Options, Option), Own),
    indigolog(Program, [ check(false), on_fact(indigolog_run:print_executed), situation(S), rest(Rest),
                         outcome(Outcome)|Own ]),
    flag(indigolog_executed, N, N),
    format("~d actions.~n", [N]),
    ended(Outcome, Options, Rest, S, Status).
run(step, Program, Options, 0) :-
    findall(replay(File), option(replay(File), Options), Own),
    step_through(Program, Own).

online_option(Options, Option) :-
    value_option(_, Name, _),
    Option =.. [Name, _],
    option(Option, Options).
online_option(Options, journal(File)) :-
    option(resume(File), Options).

ended(final, _, _, _, 0).
ended(replayed, _, _, _, 0).
ended(limit, Options, _, _, 1) :-
    option(max_actions(Max), Options),
    say('stopped after ~w actions', [Max]).
ended(aborted, _, _, _, 1) :-
    say('the program was aborted', []).
ended(failed, _, Rest, S, 1) :-
    say('the program failed', []),
    explained(Rest, S).

explained(Question, S) :-
    why(Question, S, Whys),
    explained(Whys).

explained([]) :-
    !.
explained(Whys) :-
    phrase(explanations(Whys), Lines),
    print_message_lines(user_error, '', Lines).

:- public print_executed/2.

print_executed(executed(_, A, _), _) :-
    \+ own_step(A),
    flag(indigolog_executed, N, N+1),
    format("~q~n", [A]),
    flush_output.
print_executed(failed(_, A, Reason), _) :-
    phrase('$messages':translate_message(error(Reason, _)), Words),
    phrase(([ '~q failed: '-[A] ], list(Words)), Parts),
    print_message_lines(user_error, '', Parts).

list([]) --> [].
list([Part|Parts]) --> [Part], list(Parts).

printed(History) :-
    reverse(History, Actions),
    exclude(own_step, Actions, Executed),
    forall(member(A, Executed), format("~q~n", [A])),
    length(Executed, N),
    format("~d actions.~n", [N]).

failed(usage(Message), _, 2) :-
    !,
    say('~w', [Message]),
    format(user_error, "~w~n", ['Try: swipl indigolog/run.pl -- --help']).
failed(stopped(_), _, 1) :-
    !,
    say('stopped', []).
failed(unwind(halt(Status)), _, Status) :-
    !.
failed(error(golog(reported), _), _, 2) :-
    !.
failed(no_theory(Theory), _, 2) :-
    !,
    say('no theory file ~w', [Theory]).
failed(error(Why, _), Argv, 2) :-
    cannot_open(Why, File),
    member(Word, Argv),
    atom_concat(Before, File, Word),
    memberchk(Before, ['', '--journal=', '--resume=', '--replay=']),
    !,
    say('cannot open the journal ~w', [File]).
failed(Error, _, 2) :-
    phrase('$messages':translate_message(Error), Parts),
    with_output_to(string(Text), print_message_lines(current_output, '', Parts)),
    say('Error: ~w', [Text]).

% Files that the command names, other than the theory, are journals.
cannot_open(existence_error(source_sink, File), File).
cannot_open(permission_error(open, source_sink, File), File).

say(Format, Args) :-
    format(user_error, Format, Args),
    nl(user_error).
