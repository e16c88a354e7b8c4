:- module(test_json, []).
:- use_module(library(plunit)).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(random)).
:- use_module('../../bridge/prolog/json').

:- begin_tests(json_reading).

test(values, Term = _{a:[1, -2.5, "x", null, true, false], b:_{c:_{}}, d:[]}) :-
    json_term(" { \"a\" : [1,-2.5,\"x\",null,true,false] , \"b\":{\"c\":{ }},\n\t\"d\":[ ]}\r\n", Term).
test(scalars, Terms == [1, "a", null, 0.0, -0.0]) :-
    maplist(json_term, ["1", "\"a\"", "null", "0e0", "-0.0"], Terms).
test(escapes, Codes == [0'", 0'\\, 0'/, 8, 12, 10, 13, 9, 0, 0xe9, 0x1d11e]) :-
    json_term("\"\\\"\\\\\\/\\b\\f\\n\\r\\t\\u0000\\u00E9𝄞\"", Text),
    string_codes(Text, Codes).
test(large_integers, Terms == [9223372036854775808, -123456789012345678901234567890]) :-
    maplist(json_term, ["9223372036854775808", "-123456789012345678901234567890"], Terms).
test(floats_are_exact, [X, Y, Z] == [0.1, 1.7976931348623157e308, 5.0e-324]) :-
    maplist(json_term, ["0.1", "1.7976931348623157E+308", "5e-324"], [X, Y, Z]).
test(keys_are_atoms, Keys == ['1', 'a b', 'é']) :-
    json_term("{\"a b\":1,\"é\":2,\"1\":4}", Dict),
    dict_pairs(Dict, _, Pairs),
    findall(Key, member(Key-_, Pairs), Keys0),
    msort(Keys0, Keys).
test(nested, Depth == 400) :-
    nested(400, Text),
    json_term(Text, Term),
    depth(Term, Depth).
test(a_header_of_opening_brackets_alone, error(syntax_error(json(_)))) :-
    length(Codes, 1048576),
    maplist(=(0'[), Codes),
    string_codes(Text, Codes),
    json_term(Text, _).
test(bad_text_is_refused, Wrong == []) :-
    findall(Text, ( bad(Text), \+ refused(Text) ), Wrong).
test(a_key_that_comes_twice, error(syntax_error(json(duplicate_key(a))))) :-
    json_term("{\"a\":1,\"a\":2}", _).
test(an_error_says_what, error(syntax_error(json(illegal_array)))) :-
    json_term("[1, 2 3]", _).
test(damaged_text_never_does_harm) :-
    set_random(seed(12)),
    forall(between(1, 3000, _),
           ( random_term(4, Term),
             json_text(Term, Text),
             damaged(Text, Damaged),
             catch(json_term(Damaged, _), error(syntax_error(json(_)), _), true)
           )).

nested(N, Text) :-
    length(Opening, N),
    maplist(=('['), Opening),
    length(Closing, N),
    maplist(=(']'), Closing),
    append(Opening, Closing, All),
    atomic_list_concat(All, Text).

depth([], 1) :-
    !.
depth([X], D) :-
    depth(X, D0),
    D is D0+1.

refused(Text) :-
    catch(( json_term(Text, _), fail ), error(syntax_error(json(_)), _), true).

bad('').
bad(' ').
bad('{').
bad('[').
bad('[1').
bad('[1,').
bad('[,1]').
bad('[1 2]').
bad('{"a"}').
bad('{"a":}').
bad('{"a":1 "b":2}').
bad('{a:1}').
bad('{"a":1,"a":2}').
bad('{1:2}').
bad('"a').
bad('"\\').
bad('"\\u12').
bad('"\\u12g4"').
bad('"\\x41"').
bad('\'a\'').
bad('-').
bad('+1').
bad('.5').
bad('1e').
bad('1e+').
bad('1e999').
bad('0x10').
bad('NaN').
bad('Infinity').
bad('tru').
bad('truex').
bad('nulll').
bad('1 2').
bad('[] []').
bad('}').
bad(']').

damaged(Text, Damaged) :-
    string_codes(Text, Codes),
    length(Codes, Length),
    random_between(0, Length, At),
    length(Before, At),
    append(Before, After, Codes),
    random_member(How, [cut, drop, insert]),
    damage(How, Before, After, New),
    string_codes(Damaged, New).

damage(cut, Before, _, Before).
damage(drop, Before, After, New) :-
    (   After = [_|Rest]
    ->  append(Before, Rest, New)
    ;   New = Before
    ).
damage(insert, Before, After, New) :-
    string_codes("{}[],:\"\\0-.eu\u00e9", Codes),
    random_member(Code, Codes),
    append(Before, [Code|After], New).

:- end_tests(json_reading).

:- begin_tests(json_writing).

test(values, Text == "{\"a\":[1,-2.5,\"x\",\"x\",null,true,[]]}") :-
    json_text(_{a:[1, -2.5, "x", x, null, true, []]}, Spaced),
    split_string(Spaced, " ", "", Parts),
    atomic_list_concat(Parts, Text0),
    atom_string(Text0, Text).
test(a_variable, error(instantiation_error)) :-
    json_text(_{a:_}, _).
test(a_compound, error(type_error(json_term, f(x)))) :-
    json_text([f(x)], _).
test(there_and_back) :-
    set_random(seed(13)),
    forall(between(1, 1000, _),
           ( random_term(5, Term),
             json_text(Term, Text),
             json_term(Text, Back),
             Back =@= Term
           )).
test(nothing_is_left_behind) :-
    numlist(1, 50, Ns),
    json_text(_{numbers:Ns, text:"é"}, Text),
    forall(between(1, 1000, _), ( json_term(Text, T), json_text(T, _) )),
    once(( between(1, 5, _),            % memory of other threads, once taken, is not taken again
           resident(Before),
           forall(between(1, 4000, _), ( json_term(Text, T), json_text(T, _) )),
           resident(After),
           After - Before < 4000
         )).

resident(KiB) :-
    garbage_collect,
    garbage_collect_atoms,
    setup_call_cleanup(open('/proc/self/statm', read, In), read_term_line(In, Pages), close(In)),
    KiB is Pages*4.

read_term_line(In, Pages) :-
    read_string(In, _, Line),
    split_string(Line, " ", "\n", [_, Resident|_]),
    number_string(Pages, Resident).

:- end_tests(json_writing).

%!  random_term(+Depth, -Term) is det.
%
%   Any term that JSON can carry and that comes back as it was.

random_term(0, Term) :-
    !,
    random_scalar(Term).
random_term(Depth, Term) :-
    D is Depth-1,
    random_between(0, 4, Kind),
    (   Kind =:= 0
    ->  random_scalar(Term)
    ;   Kind =< 2
    ->  random_between(0, 4, N),
        length(Term, N),
        maplist(random_term(D), Term)
    ;   random_between(0, 4, N),
        findall(Key-Value, ( between(1, N, I), random_key(I, Key), random_term(D, Value) ), Pairs),
        dict_pairs(Term, _, Pairs)
    ).

random_key(I, Key) :-
    random_text(Text),
    format(atom(Key), '~wk~w', [Text, I]).

random_text(Text) :-
    random_between(0, 6, N),
    length(Codes, N),
    maplist(random_code, Codes),
    string_codes(Text, Codes).

random_code(Code) :-
    random_member(Code, [0'a, 0'", 0'\\, 0'/, 10, 9, 1, 0x7f, 0xe9, 0x20ac, 0x1d11e, 0' , 0'{]).

random_scalar(Term) :-
    random_between(0, 5, Kind),
    random_scalar(Kind, Term).

random_scalar(0, Term) :-
    random_member(Term, [true, false, null]).
random_scalar(1, Term) :-
    random_between(-1000, 1000, Term).
random_scalar(2, Term) :-
    random_between(0, 100, E),
    random_between(-9, 9, M),
    Term is M*7**E.
random_scalar(3, Term) :-
    random(R),
    random_between(-300, 300, E),
    Term is R*10.0**E.
random_scalar(4, Term) :-
    random_text(Term).
random_scalar(5, Term) :-
    random_between(0, 1, Term).
