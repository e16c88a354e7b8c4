:- module(test_types, []).
:- use_module(library(plunit)).
:- use_module(fixtures).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(lists), [member/2]).
:- use_module('../../bridge/prolog/client').
:- use_module('../../bridge/prolog/results', [result/3]).
:- use_module('../../bridge/prolog/types').

%   What an estimate from one image is answered with.
estimated(Endpoint, Result) :-
    setup_call_cleanup(client_open(Endpoint, Client, [timeout(60), server(vision_server)]),
                       ( client_request(Client, start, _{image_server:"ipc:///i"}, _, []),
                         Settings = _{lights:[7, 7, 7], shutter_s:0.01667, aperture:4.0},
                         client_request(Client, capture, _{image:i1, settings:Settings}, _, []),
                         client_request(Client, estimate, _{images:[i1]}, Result, [])
                       ),
                       client_close(Client)).

%   Value with one thing in it taken away or made another.
mutated(Dict, Mutated) :-
    is_dict(Dict),
    get_dict(Key, Dict, Value),
    (   del_dict(Key, Dict, _, Mutated)
    ;   ( odd(Odd) ; mutated(Value, Odd) ),
        put_dict(Key, Dict, Odd, Mutated)
    ).
mutated([First|Rest], Mutated) :-
    (   Mutated = Rest
    ;   ( odd(Odd) ; mutated(First, Odd) ),
        Mutated = [Odd|Rest]
    ).

odd(Odd) :-
    Infinite is inf,
    member(Odd, [true, -1, 1.0e300, "text", "", [], [[]], _{}, _{a:1}, Infinite]).

:- begin_tests(results_of_the_right_types).

test(what_a_server_answers_fits) :-
    with_mock(vision, _{}, Endpoint, estimated(Endpoint, Result)),
    check_result(vision_server, estimate, Result).
test(whatever_is_changed_in_an_answer_it_is_said_where_or_does_no_harm) :-
    with_mock(vision, _{}, Endpoint, estimated(Endpoint, Result)),
    aggregate_all(count, mutated(Result, _), All),
    aggregate_all(count,
                  ( mutated(Result, Mutated),
                    catch(( check_result(vision_server, estimate, Mutated), fail ), misfit(Where, What), true),
                    assertion(( string(Where) ; Where == result )),
                    assertion(nonvar(What))
                  ),
                  Refused),
    assertion(All > 200),
    assertion(Refused > 0.7*All).
test(what_does_not_fit_is_a_plain_error, [nondet]) :-
    with_mock(vision, _{estimate:_{amend:_{score:"high"}}}, Endpoint,
              catch(estimated(Endpoint, _), error(server_error(bad_reply, Message, _), _), true)),
    sub_string(Message, _, _, _, "result.score should be number").
test(every_operation_has_a_type, Missing == []) :-
    findall(Op, ( member(Op, [start, capture, estimate, discard, parameters, restore, end, predict]),
                  \+ result(vision_server, Op, _) ), Missing).

:- end_tests(results_of_the_right_types).
