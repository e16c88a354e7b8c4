:- module(session_strategy_file,
          [ strategy_files/2,           % +File, -Files
            strategy_sha256/2,          % +File, -Sha256
            in_strategy/3,              % +File, ?Term, -Place
            in_strategy/4,              % +File, ?Term, -Clause, -Place
            program_part/4,             % +File, ?Part, -Around, -Place
            place_of/3,                 % +File, +Terms, -Place
            places_of/3                 % +File, +Terms, -Place
          ]).
/** <module> The files of a strategy: their terms, with their places

A place is FILE:LINE.  Nothing is told of what cannot be read: the interpreter says that.
*/

:- use_module('../folder/session_file', [file_sha256/2]).
:- use_module('../usage_errors', [usage_error/2]).
:- use_module('../../indigolog/tools/program_parts', [part_within/3]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/2, member/2, nth1/3]).
:- use_module(library(pairs), [pairs_keys/2, pairs_values/2]).
:- use_module(library(prolog_source), [prolog_close_source/1, prolog_open_source/2, prolog_read_source_term/4]).
:- use_module(library(readutil), [read_file_to_string/3]).
:- use_module(library(sha), [hash_atom/2, sha_hash/3]).

                /*******************************
                *           ITS FILES          *
                *******************************/

%!  strategy_files(+File, -Files) is det.
%
%   The file, and after it those that it includes, at any depth.

strategy_files(File, Files) :-
    with_included([], File, Files).

%   Above are the files that include it, the nearest first.
with_included(Above, File, [File|Files]) :-
    findall(Other-Line, included(File, Other, Line), Pairs),
    forall(( member(Other-Line, Pairs), member(One, [File|Above]), same_file(Other, One) ),
           usage_error("~w:~d: it includes ~w, which is included by it: loading would never end", [File, Line, Other])),
    pairs_keys(Pairs, Others),
    maplist(with_included([File|Above]), Others, Lists),
    append(Lists, Files).

included(File, Other, Line) :-
    in_file(File, (:- include(Given)), _, Line),
    ground(Given),
    absolute_file_name(Given, Other, [extensions(['', pl]), access(read), relative_to(File), file_errors(fail)]).

%!  strategy_sha256(+File, -Sha256) is det.
%
%   Of the file alone where it includes none, else of those of all.

strategy_sha256(File, Sha256) :-
    strategy_files(File, Files),
    maplist(file_sha256, Files, Hashes),
    (   Hashes = [Sha256]
    ->  true
    ;   atomic_list_concat(Hashes, All),
        sha_hash(All, Bytes, [algorithm(sha256), encoding(utf8)]),
        hash_atom(Bytes, Sha256)
    ).

                /*******************************
                *           ITS TERMS          *
                *******************************/

%!  in_strategy(+File, ?Term, -Place) is nondet.
%!  in_strategy(+File, ?Term, -Clause, -Place) is nondet.
%
%   Where Term is at any depth of a Clause of the file, or of one that it includes; its own come first.

in_strategy(File, Term, Place) :-
    in_strategy(File, Term, _, Place).

in_strategy(File, Term, Clause, Place) :-
    strategy_files(File, Files),
    member(One, Files),
    in_file(One, Term, Clause, Line),
    format(atom(Place), "~w:~d", [One, Line]).

%!  program_part(+File, ?Part, -Around, -Place) is nondet.
%
%   Part is the program of a procedure, or a part of one, which stands in the constructs and calls Around (program_parts.pl).

program_part(File, Part, Around, Place) :-
    strategy_files(File, Files),
    member(One, Files),
    read_clause(One, Text, Clause, Position),
    ( Clause = (Head :- _) -> true ; Head = Clause ),
    nonvar(Head),
    Head = proc(_, Body),
    part_within(Body, Own, Around),
    Part = Own,
    once(( subterm(Clause, Position, Sub, At), same_term(Sub, Own) )),
    line_at(Text, At, Line),
    format(atom(Place), "~w:~d", [One, Line]).

%!  place_of(+File, +Terms, -Place) is det.
%
%   Where the first of Terms that is anywhere in the strategy may be; its file alone where none is.

place_of(File, Terms, Place) :-
    (   member(Term, Terms),
        nonvar(Term),
        found_place(File, [Term], Found)
    ->  Place = Found
    ;   Place = File
    ).

%!  places_of(+File, +Terms, -Place) is det.
%
%   The same, where any of Terms may be.

places_of(File, Terms, Place) :-
    ( found_place(File, Terms, Found) -> Place = Found ; Place = File ).

found_place(File, Terms, Place) :-
    strategy_files(File, Files),
    member(One, Files),
    findall(Clause-Line, ( member(Term, Terms), in_file(One, Term, Clause, Line) ), Found),
    findall(Line, ( member(Clause-Line, Found), of_procedure(Clause) ), InProcedures),
    ( InProcedures = [_|_] -> Lines = InProcedures ; pairs_values(Found, Lines) ),
    lines_place(Lines, One, Place),
    !.

%   What a step does is written there; an action is also in the axioms that speak of it.
of_procedure(proc(_, _)).
of_procedure((proc(_, _) :- _)).

lines_place(Lines, File, Place) :-
    sort(Lines, [First|More]),
    (   More == []
    ->  format(atom(Place), "~w:~d", [File, First])
    ;   atomic_list_concat([First|More], ', ', Listed),
        format(atom(Place), "~w, line ~w", [File, Listed])
    ).

%   in_file(+File, ?Term, -Clause, -Line): where Term is in the file, at any depth of a clause.
in_file(File, Term, Clause, Line) :-
    read_clause(File, Text, Clause, Position),
    subterm(Clause, Position, Term, At),
    line_at(Text, At, Line).

                /*******************************
                *            READING           *
                *******************************/

read_clause(File, Text, Clause, Position) :-
    catch(file_terms(File, Text, Terms), error(_, _), fail),
    member(Clause-Position, Terms).

%   Operators are those that its directives make, as where it is loaded: its own, and those of libraries.
file_terms(File, Text, Terms) :-
    read_file_to_string(File, Text, [encoding(utf8)]),
    setup_call_cleanup(prolog_open_source(File, Stream),
                       ( set_stream(Stream, encoding(utf8)),
                         style_check(-singleton),           % told where it is loaded
                         positioned(Stream, Terms) ),
                       prolog_close_source(Stream)).

positioned(Stream, Terms) :-
    prolog_read_source_term(Stream, Term, _, [syntax_errors(error), subterm_positions(Position)]),
    (   Term == end_of_file
    ->  Terms = []
    ;   Terms = [Term-Position|More],
        positioned(Stream, More)
    ).

%   subterm(+Term, +Position, ?Sub, -At): Sub is Term, or in it, and not a variable; it begins At this character.
subterm(Term, Position, Sub, At) :-
    nonvar(Term),
    Sub = Term,
    begins(Position, At).
subterm(Term, term_position(_, _, _, _, Positions), Sub, At) :-
    nth1(N, Positions, Position),
    arg(N, Term, Argument),
    subterm(Argument, Position, Sub, At).
subterm(List, list_position(_, _, Positions, _), Sub, At) :-
    nth1(N, Positions, Position),
    nth1(N, List, Element),
    subterm(Element, Position, Sub, At).
subterm(Term, parentheses_term_position(_, _, Position), Sub, At) :-
    subterm(Term, Position, Sub, At).

begins(From-_, From).
begins(term_position(From, _, _, _, _), From).
begins(list_position(From, _, _, _), From).
begins(parentheses_term_position(From, _, _), From).

line_at(Text, At, Line) :-
    sub_string(Text, 0, At, _, Before),
    split_string(Before, "\n", "", Lines),
    length(Lines, Line).
