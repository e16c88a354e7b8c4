:- module(test_indigolog_mutations, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [member/2]).
:- use_module(library(readutil), [read_file_to_string/3, read_file_to_terms/3]).

/** <module> Each mistake that mutations.pl plants has its place in the interpreter as it is */

here(Path, File) :-
    module_property(test_indigolog_mutations, file(Here)),
    file_directory_name(Here, Folder),
    atomic_list_concat([Folder, /, Path], File).

times(File, Text, Count) :-
    atomic_list_concat(['../../indigolog/*/', File, '.pl'], Relative),
    here(Relative, Pattern),
    expand_file_name(Pattern, [Path]),
    read_file_to_string(Path, Source, [encoding(utf8)]),
    findall(B, sub_string(Source, B, _, _, Text), Places),
    length(Places, Count).

:- begin_tests(mutations).

test(each_has_one_place, true(Lost == [])) :-
    here('mutations.pl', Mutations),
    read_file_to_terms(Mutations, Terms, [encoding(utf8)]),
    findall(What, ( member(mutation(What, File, Old, _), Terms), \+ times(File, Old, 1) ), Lost).

:- end_tests(mutations).
