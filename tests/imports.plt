:- module(test_imports, []).
:- use_module(library(plunit)).
:- use_module(library(lists), [memberchk/2]).
:- use_module(library(ugraphs), [neighbours/3]).
:- use_module(imports).

/** <module> No large cycle of imports, and no layer of the interpreter knows those above it */

% Formulas, situations and knowledge are defined by one another.
largest_cycle(3).

:- begin_tests(imports).

test(cycles, Cycles == []) :-
    import_graph(Graph),
    largest_cycle(Most),
    large_cycles(Graph, Most, Cycles).

test(a_cycle_is_found, Cycles == [[a, b, c]]) :-
    large_cycles([a-[b], b-[c], c-[a, d], d-[]], 2, Cycles).

test(layers, Edges == []) :-
    import_graph(Graph),
    layer_breaches(Graph, Edges).

test(a_breach_is_found, Edges == ['indigolog/language/a.pl'-'indigolog/tools/b.pl']) :-
    layer_breaches(['indigolog/language/a.pl'-['indigolog/tools/b.pl'],
                    'indigolog/tools/b.pl'-['indigolog/language/a.pl']], Edges).

test(whole_graph, true) :-                % it was read: the face of the interpreter loads many
    import_graph(Graph),
    neighbours('indigolog/indigolog.pl', Graph, Loaded),
    memberchk('indigolog/language/golog.pl', Loaded).

:- end_tests(imports).
