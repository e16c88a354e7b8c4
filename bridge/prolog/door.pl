/** <module> The Prolog side of Python's door into Prolog

A goal comes in as text and all its answers go out as one line of JSON, both in base64, so that nothing depends on how
the caller converts terms. Terms that JSON has no word for are objects with one key that starts with a dollar sign.
*/

:- module(bridge_door,
          [ door_answers/3          % +Goal64, +Most, -Answers64
          ]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(base64), [base64_encoded/3]).
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(solution_sequences), [limit/2]).

%!  door_answers(+Goal64, +Most, -Answers64) is det.
%
%   Answers64 stands for `{"answers": [{"X": ...}, ...]}` with at most Most answers of the goal, or for
%   `{"error": Text, "term": Text}`. The goal runs in `user`, to its end: nothing stays open.

door_answers(Goal64, Most, Answers64) :-
    catch(answers(Goal64, Most, Result), Error, error_result(Error, Result)),
    with_output_to(string(Text), json_write_dict(current_output, Result, [width(0)])),
    base64_encoded(Text, Answers64, [as(string), encoding(utf8)]).

answers(Goal64, Most, _{answers:Answers}) :-
    base64_encoded(Text, Goal64, [as(string), encoding(utf8)]),
    term_string(Goal, Text, [variable_names(Bindings), module(user)]),
    findall(Answer,
            ( limit(Most, call(user:Goal)),
              answer(Bindings, Answer)
            ),
            Answers).

answer(Bindings, Answer) :-
    maplist(binding, Bindings, Pairs),
    dict_pairs(Answer, _, Pairs).

binding(Name=Term, Name-Json) :-
    term_json(Term, Json).

error_result(Error, _{error:Text, term:Term}) :-
    message_to_text(Error, Text),
    term_text(Error, Term).

message_to_text(Error, Text) :-
    '$messages':translate_message(Error, Lines, []),
    with_output_to(string(Raw), print_message_lines(current_output, '', Lines)),
    normalize_space(string(Text), Raw).

term_text(Term, Text) :-
    format(string(Text), '~q', [Term]).

%!  term_json(+Term, -Json) is det.

term_json(Term, Json), var(Term) =>
    term_text(Term, Name),
    Json = _{'$variable':Name}.
term_json(Term, Json), string(Term) =>
    Json = Term.
term_json(Term, Json), integer(Term) =>
    Json = Term.
term_json(Term, Json), rational(Term, N, D) =>
    Json = _{'$rational':[N, D]}.
term_json(Term, Json), float(Term) =>
    (   ( Term =\= Term ; abs(Term) =:= inf )
    ->  term_text(Term, Text),
        Json = _{'$float':Text}
    ;   Json = Term
    ).
term_json(Term, Json), atom(Term) =>
    atom_string(Term, Text),
    Json = _{'$atom':Text}.
term_json([], Json) =>
    Json = [].
term_json(Term, Json), is_list(Term) =>
    maplist(term_json, Term, Json).
term_json(Term, Json), is_dict(Term) =>
    dict_pairs(Term, _, Pairs),
    maplist(pair_json, Pairs, Jsons),
    Json = _{'$dict':Jsons}.
term_json(Term, Json), compound(Term) =>
    compound_name_arguments(Term, Name, Args),
    maplist(term_json, Args, Jsons),
    Json = _{'$term':Name, args:Jsons}.
term_json(Term, Json) =>
    term_text(Term, Text),
    Json = _{'$blob':Text}.

pair_json(Key-Term, [Name, Json]) :-
    format(string(Name), '~w', [Key]),
    term_json(Term, Json).
