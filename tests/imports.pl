:- module(imports,
          [ import_graph/1,           % -Graph
            large_cycles/3,           % +Graph, +Most, -Cycles
            layer_breaches/2          % +Graph, -Edges
          ]).
:- use_module(library(filesex), [directory_member/3, relative_file_name/3]).
:- use_module(library(lists), [member/2]).
:- use_module(library(ordsets), [ord_intersection/3]).
:- use_module(library(ugraphs), [reachable/3, transpose_ugraph/2, vertices/2, vertices_edges_to_ugraph/3]).

/** <module> Which of our Prolog files import which */

%!  import_graph(-Graph) is det.
%
%   Graph (library(ugraphs)) has an edge from each file of ours to each that it loads, by
%   use_module, reexport or ensure_loaded; files are named from the project's folder.

import_graph(Graph) :-
    root(Root),
    findall(File, source_file_of(Root, File), Files),
    findall(From-To, ( member(From, Files), loads(Root, From, To) ), Edges),
    vertices_edges_to_ugraph(Files, Edges, Graph).

root(Root) :-
    module_property(imports, file(Here)),
    file_directory_name(Here, Tests),
    file_directory_name(Tests, Root).

source_file_of(Root, File) :-
    member(Folder, [indigolog, domain, session, bridge]),
    atomic_list_concat([Root, /, Folder], Path),
    directory_member(Path, Whole, [recursive(true), extensions([pl])]),
    from_root(Root, Whole, File).
source_file_of(_, 'main.pl').

from_root(Root, Whole, File) :-
    atom_concat(Root, '/_', Anchor),
    relative_file_name(Whole, Anchor, File).

loads(Root, File, Loaded) :-
    atomic_list_concat([Root, /, File], Whole),
    setup_call_cleanup(open(Whole, read, Stream),
                       directives(Stream, Directives),
                       close(Stream)),
    member(Directive, Directives),
    loading(Directive, Spec),
    \+ Spec = library(_),
    absolute_file_name(Spec, Found, [relative_to(Whole), extensions([pl]), access(read), file_errors(fail)]),
    from_root(Root, Found, Loaded).

% Operators that a file declares are not needed to read what it loads.
directives(Stream, Directives) :-
    catch(read_term(Stream, Term, []), error(syntax_error(_), _), Term = skipped),
    (   Term == end_of_file
    ->  Directives = []
    ;   Term = (:- Directive)
    ->  Directives = [Directive|More],
        directives(Stream, More)
    ;   directives(Stream, Directives)
    ).

loading(use_module(Spec), Spec).
loading(use_module(Spec, _), Spec).
loading(reexport(Spec), Spec).
loading(reexport(Spec, _), Spec).
loading(ensure_loaded(Spec), Spec).

%!  large_cycles(+Graph, +Most, -Cycles) is det.
%
%   Cycles are the strongly connected components of Graph with more than Most files.

large_cycles(Graph, Most, Cycles) :-
    transpose_ugraph(Graph, Back),
    vertices(Graph, Files),
    findall(Cycle,
            ( member(File, Files),
              reachable(File, Graph, There),
              reachable(File, Back, Here),
              ord_intersection(There, Here, Cycle),
              Cycle = [File|_],           % each once
              length(Cycle, N),
              N > Most ),
            Cycles).

%!  layer_breaches(+Graph, -Edges) is det.
%
%   Edges From-To by which a layer of indigolog/ loads one above it, or what is not of it.

layer_breaches(Graph, Edges) :-
    findall(From-To,
            ( member(From-Tos, Graph),
              layer(From, Low),
              member(To, Tos),
              \+ ( layer(To, High), High =< Low ) ),
            Edges).

layer(File, Layer) :-
    atomic_list_concat([indigolog|Parts], /, File),
    (   Parts = [Folder, _],
        height(Folder, Layer)
    ->  true
    ;   Parts = [_],
        Layer = 5                         % indigolog.pl, run.pl
    ).

height(language, 1).
height(search, 2).
height(online, 3).
height(tools, 4).
height(prolog, 6).
