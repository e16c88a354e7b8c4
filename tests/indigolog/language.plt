:- module(test_indigolog_language, []).
:- use_module(library(plunit)).
:- use_module(library(apply), [include/3]).
:- use_module(library(lists), [reverse/2, member/2, memberchk/2]).
:- use_module(library(occurs), [sub_term/2]).
:- use_module(library(readutil), [read_file_to_string/3]).
:- use_module('../../indigolog/indigolog').

/** <module> The examples of docs/language.md are true */

% documented(-Program, -Given, -Expected): Given is `offline`, or the sensing results.
documented(Program, Given, Expected) :-
    module_property(test_indigolog_language, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/../../docs/language.md', File),
    read_file_to_string(File, Text, [encoding(utf8)]),
    split_string(Text, "\n", "", Lines),
    member(Line, Lines),
    string_concat("    ", Example, Line),
    sub_string(Example, Before, 1, _, "⇒"),
    sub_string(Example, 0, Before, _, Left),
    After is Before + 1,
    sub_string(Example, After, _, 0, Right),
    (   sub_string(Left, At, 7, _, " given ")
    ->  sub_string(Left, 0, At, _, Left1),
        End is At + 7,
        sub_string(Left, End, _, 0, Results),
        term_string(Program, Left1),
        term_string(Given, Results)
    ;   term_string(Program, Left),
        Given = offline
    ),
    term_string(Expected, Right).

load(Name) :-
    module_property(test_indigolog_language, file(Here)),
    file_directory_name(Here, Folder),
    atomic_list_concat([Folder, '/theories/', Name, '.pl'], Theory),
    load_theory(Theory).

:- dynamic result/1.

answering:can_execute(_).
answering:execute(Action, Result) :-
    (   memberchk(Action, [knock, peek, look])
    ->  retract(test_indigolog_language:result(Result))
    ;   Result = none
    ).

given(Results) :-
    retractall(result(_)),
    forall(member(R, Results), assertz(result(R))).

is_action(Entry) :-
    Entry \= e(_, _).

:- begin_tests(language).

test(examples, [forall(documented(Program, offline, Expected)), Traces == Expected]) :-
    load(lights),
    findall(Trace, ( do(Program, [], History), reverse(History, Trace) ), Traces0),
    sort(Traces0, Traces).

test(examples_online, [forall(( documented(Program, Given, Expected), Given \== offline )), Trace == Expected]) :-
    load(treasure),
    given(Given),
    indigolog(Program, [device(answering), history(History), outcome(Outcome)]),
    (   Outcome == final
    ->  include(is_action, History, Actions),
        reverse(Actions, Trace)
    ;   Trace = Outcome
    ).

test(there_are_examples, true(Count >= 60)) :-
    findall(P, documented(P, _, _), Programs),
    length(Programs, Count).

% Every construct of the table has an example.
test(all_constructs, [forall(construct(Name)), true(Examples \== [])]) :-
    findall(P, ( documented(P, _, _), sub_term(T, P), callable(T), functor(T, Name, _) ), Examples).

construct(Name) :-
    member(Name, [??, ?, ndet, wndet, rndet, if, while, star, pi, rpi, for, conc, pconc, iconc, rconc, rrobin, sync,
                  prioritized_interrupts, interrupt, gexec, goal, abort, atomic, time, ttime, set, unset, sim, search,
                  searchc, branch, case, achieve, wait, and, or, neg, impl, equiv, some, all, know, kwhether, done, findall]).

:- end_tests(language).
