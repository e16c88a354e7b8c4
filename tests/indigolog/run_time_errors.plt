:- module(test_indigolog_run_time_errors, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [member/2]).
:- use_module('../../indigolog/indigolog').

/** <module> What goes wrong while a program runs is told with its place, and nothing is lost */

load :-
    module_property(test_indigolog_run_time_errors, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/slips.pl', File),
    load_theory(File).

obedient:can_execute(_).
obedient:execute(_, none).

% printed(+Program, -Text): the error that ends an online run of Program.
printed(Program, Text) :-
    printed(Program, [], Text).

printed(Program, Options, Text) :-
    catch(( indigolog(Program, [check(false), device(obedient), max_silent(1000)|Options]), Error = none ), Error, true),
    in_words(Error, Text).

in_words(Error, Text) :-
    phrase('$messages':translate_message(Error), Parts),
    with_output_to(string(Text), print_message_lines(current_output, '', Parts)).

says(Text, Line) :-
    sub_string(Text, _, _, _, Line),
    !.

:- begin_tests(run_time_errors, [setup(load)]).

slip([up, lift(3)], ["fluent load has no value", "at ?(load>3)", "with call(lift(3))", "after 1 actions, newest first [up]"]).
slip(pi((n, [2, 3]), [?(load > n), up]), ["fluent load has no value", "at ?(load>2)", "with n=2", "in the initial situation"]).
slip([up, pi((n, [5, 7]), pi((m, [6]), if(n > m, [?(load = n), up], ?(false))))],
     ["at ?(load=7)", "with n=7", "with m=6"]).
slip([up, ?(3)], ["3 is not a formula", "after 1 actions"]).
slip([up, ?(X), up], ["not a formula", "in [?(", "after 1 actions"]) :- var(X).
slip([up, ?([up])], ["[up] is not a formula", "after 1 actions"]).
slip([up, ?(unheard_of(floor))], ["unheard_of/1 is neither a fluent nor an abbreviation nor a predicate", "in ?(unheard_of(floor))"]).
slip([up, ?(some(x, [1, 5], tidy(x)))], ["fluent tidy(5) is not one of those that are declared", "in ?(some(x,[1,5],tidy(x)))"]).
slip([up, sweep(5)], ["fluent tidy(5) is not one of those that are declared", "in sweep(5)"]).
slip([up, fall(floor)], ["no clause of the procedure fall/1 matches fall(floor): the fluent floor is handed over by name"]).
slip([up, pi(x, [?(x = floor), fall(x)]), fall(7)], ["no clause of the procedure fall/1 matches fall(7)\n"]).
slip([up, fly], ["fly/0 is neither an action nor a procedure", "after 1 actions"]).
slip([up, carry(_)], ["action carry(", "is not ground"]).
slip([up, ?(floor > down)], ["down", "at ?(floor>down)"]) :- fail.
slip([up, commit], ["commit is not of this language", "after 1 actions, newest first [up]"]).
slip([up, spin], ["the program made 1,000 steps without an action", "after 1 actions, newest first [up]"]).
slip([up, star(?(true))], ["the program made 1,000 steps without an action"]).
slip([up, deeper(0)], ["procedure calls nest 1,000 deep without an action"]).
slip([up, pi((n, nowhere), ?(n = 1))], ["nowhere is neither a list nor a predicate"]).
slip([up, up, up, up], ["the program ended as failed after 3 actions", "action up is not possible", "floor = 4"]).

test(told, [forall(slip(Program, Lines)), true(Missing == [])]) :-
    printed(Program, Text),
    findall(Line-Text, ( member(Line, Lines), \+ says(Text, Line) ), Missing).

% Offline it is asked first whether a program may end.
test(told_offline, true(says(Text, "in while(load>3,up)\n  after 1 actions, newest first [up]"))) :-
    catch(do([up, while(load > 3, up)], [], _), Error, true),
    in_words(Error, Text).

% A device that answers what cannot be: said where it happens, not where it is missed.
test(no_truth_value, [setup(load), error(golog(not_boolean_result(listen, noisy, loud)))]) :-
    indigolog([up, listen, ?(noisy)], [check(false), device(deaf)]).

deaf:can_execute(_).
deaf:execute(A, Result) :- ( A == listen -> Result = loud ; Result = none ).

test(history_is_kept, [setup(tmp_file(journal, File)), cleanup(delete_file(File)), true(Actions == [up, up])]) :-
    printed([up, up, ?(load > 1)], [journal(File)], _),
    read_file_to_terms(File, Facts, []),
    findall(A, member(executed(_, A, _), Facts), Actions),
    memberchk(ended(error(_)), Facts).

test(offline_loop_is_told, error(golog(silent(100000)))) :-
    do(growing(0), [], _).

:- end_tests(run_time_errors).
