/** <module> Values of JSON against the types of the protocol's messages */

:- module(bridge_types,
          [ check_result/3          % +Server, +Op, +Result
          ]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [member/2, memberchk/2, nth0/3, same_length/2]).
:- use_module(results, [message/2, result/3]).

%!  check_result(+Server, +Op, +Result) is det.
%
%   Result, a dict, is what an operation of image_server or vision_server answers; keys that are not known are let be.
%   Nothing is said of operations that are not known.
%
%   @throws misfit(Where, What) for a value that does not fit, What being what it should be

check_result(Server, Op, Result) :-
    (   result(Server, Op, Type)
    ->  check_type(Type, Result, result)
    ;   true
    ).

%!  check_type(+Type, +Value, +Where) is det.
%
%   Where is a text, as of Python: `result.lines[3].support`.

check_type(Type, Value, Where) :-
    (   fits(Type, Value, Where)
    ->  true
    ;   wanted(Type, What),
        throw(misfit(Where, What))
    ).

fits(any, _, _).
fits(boolean, Value, _) :-
    memberchk(Value, [true, false]).
fits(string, Value, _) :-
    string(Value).
fits(one_of(Choices), Value, _) :-
    memberchk(Value, Choices).
fits(number(Bounds), Value, _) :-
    number(Value),
    abs(Value) < inf,
    within(Bounds, Value).
fits(integer(Bounds), Value, _) :-
    integer(Value),
    within(Bounds, Value).
fits(list(Type, Least, Most), Values, Where) :-
    is_list(Values),
    length(Values, Count),
    Count >= Least,
    Count =< Most,
    items(Values, Type, Where).
fits(tuple(Types), Values, Where) :-
    is_list(Values),
    same_length(Types, Values),
    forall(nth0(I, Types, Type),
           ( nth0(I, Values, Value),
             below(Where, I, There),
             check_type(Type, Value, There)
           )).
fits(map(Type), Value, Where) :-
    is_dict(Value),
    forall(get_dict(Key, Value, Item), check_field(Key, Type, Item, Where)).
fits(message(Name), Value, Where) :-
    is_dict(Value),
    message(Name, Fields),
    forall(member(Field, Fields), field(Field, Value, Where)).
fits(nullable(Type), Value, Where) :-
    (   Value == null
    ->  true
    ;   fits(Type, Value, Where)
    ).

field(Key-optional(Type), Dict, Where) :-
    !,
    (   get_dict(Key, Dict, Value)
    ->  check_field(Key, Type, Value, Where)
    ;   true
    ).
field(Key-Type, Dict, Where) :-
    (   get_dict(Key, Dict, Value)
    ->  check_field(Key, Type, Value, Where)
    ;   throw(misfit(Where, lacking(Key)))
    ).

check_field(Key, Type, Value, Where) :-
    format(string(There), "~w.~w", [Where, Key]),
    check_type(Type, Value, There).

items(Values, Type, Where) :-
    forall(nth0(I, Values, Value),
           ( below(Where, I, There),
             check_type(Type, Value, There)
           )).

below(Where, I, There) :-
    format(string(There), "~w[~w]", [Where, I]).

within(Bounds, Value) :-
    forall(member(Bound, Bounds), within_bound(Bound, Value)).

within_bound(ge(Least), Value) :- Value >= Least.
within_bound(gt(Least), Value) :- Value > Least.
within_bound(le(Most), Value) :- Value =< Most.
within_bound(lt(Most), Value) :- Value < Most.

%   In words, for a person.
wanted(number(Bounds), What) =>
    bounded(number, Bounds, What).
wanted(integer(Bounds), What) =>
    bounded('whole number', Bounds, What).
wanted(message(_), What) =>
    What = object.
wanted(map(_), What) =>
    What = object.
wanted(list(_, _, _), What) =>
    What = 'list of the right length'.
wanted(tuple(Types), What) =>
    length(Types, Count),
    format(atom(What), 'list of ~w', [Count]).
wanted(one_of(Choices), What) =>
    atomic_list_concat(Choices, ' or ', What).
wanted(nullable(Type), What) =>
    wanted(Type, Whatever),
    format(atom(What), '~w or null', [Whatever]).
wanted(Type, What) =>
    What = Type.

bounded(Kind, [], Kind) :-
    !.
bounded(Kind, Bounds, What) :-
    maplist(bound_text, Bounds, Texts),
    atomic_list_concat([Kind|Texts], ' ', What).

bound_text(Bound, Text) :-
    Bound =.. [Name, Number],
    memberchk(Name-Sign, [ge- >=, gt- >, le- =<, lt- <]),
    format(atom(Text), '~w ~w', [Sign, Number]).
