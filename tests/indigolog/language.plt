:- module(test_indigolog_language, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [reverse/2, member/2]).
:- use_module(library(readutil), [read_file_to_string/3]).
:- use_module('../../indigolog/indigolog').

/** <module> The examples of docs/language.md are true */

documented(Program, Traces) :-
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
    term_string(Program, Left),
    term_string(Traces, Right).

:- begin_tests(language).

test(examples, [forall(documented(Program, Expected)), Traces == Expected]) :-
    module_property(test_indigolog_language, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/theories/lights.pl', Theory),
    load_theory(Theory),
    findall(Trace, ( do(Program, [], History), reverse(History, Trace) ), Traces0),
    sort(Traces0, Traces).

test(there_are_examples, true(Count >= 15)) :-
    findall(P, documented(P, _), Programs),
    length(Programs, Count).

:- end_tests(language).
