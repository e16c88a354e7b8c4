:- module(test_client, []).
:- use_module(library(plunit)).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(process)).
:- use_module('../../bridge/prolog/client').
:- use_module('../../bridge/prolog/handshake', [somebody_listens/1]).
:- use_module('../../bridge/prolog/zmq').
:- use_module(fixtures).

:- meta_predicate with_client(+, +, -, 0).

with_client(Endpoint, Options, Client, Goal) :-
    setup_call_cleanup(client_open(Endpoint, Client, Options), once(Goal), client_close(Client)).

:- public counted/0.
counted :-
    nb_getval(calls, N0),
    N is N0+1,
    nb_setval(calls, N),
    (   N > 20
    ->  throw(server_gone)
    ;   fail                            % failure is no sign of anything
    ).

:- public answers/1.
answers(Thread) :-
    (   thread_property(Thread, status(running))
    ->  true
    ;   throw(impostor_gone)
    ).

:- public suspended/0.
suspended :-                            % once
    nb_getval(suspended_s, Seconds),
    nb_setval(suspended_s, 0),
    sleep(Seconds).

settings(_{lights:[7, 7, 7], shutter_s:0.0166667, aperture:4.0}).

:- begin_tests(client_and_server).

test(a_session_with_a_vision_server) :-
    settings(Settings),
    with_mock(vision, _{}, Endpoint, with_client(Endpoint, [timeout(60), retries(60)], Client, (
        client_request(Client, start, _{image_server:"ipc:///tmp/none"}, Started, []),
        length(Started.describe.lights, 3),
        client_request(Client, capture, _{image:i1, settings:Settings}, Captured, []),
        Captured.image == "i1",
        Captured.verified == true,
        number(Captured.statistics.p50),
        client_request(Client, estimate, _{images:[i1]}, Fix, []),
        length(Fix.covariance, 6),
        client_request(Client, discard, _{image:i1}, Discarded, []),
        Discarded :< _{image:"i1", images:[]},
        client_request(Client, best, _{}, Best, []),
        Best.rms_px =:= Fix.rms_px,
        client_request(Client, parameters, _{a:1, b:0.5, c:"x", d:true}, Parameters, []),
        Parameters :< _{a:1, b:0.5, c:"x", d:true},
        client_request(Client, health, _{}, Health, []),
        Health.status == "ok",
        client_request(Client, hello, _{}, Hello, []),
        Hello.protocol == 1,
        client_seconds(Client, Seconds),
        Seconds > 0
    ))).
test(frames_stay_on_the_other_side, Sequence == 1) :-
    settings(Settings),
    with_mock(image, _{}, Endpoint, with_client(Endpoint, [timeout(60), retries(60)], Client, (
        client_request(Client, capture, _{settings:Settings}, Header, []),
        Sequence = Header.sequence
    ))).
test(lost_replies_are_asked_for_again_and_nothing_is_done_twice, Count == 1) :-
    settings(Settings),
    with_mock(vision, _{capture:_{drop:2}}, Endpoint,
              with_client(Endpoint, [timeout(60), retries(60)], Client, (
        client_request(Client, hello, _{}, _, []),
        client_request(Client, capture, _{image:i1, settings:Settings}, _, []),
        client_request(Client, health, _{}, Health, []),
        Count = Health.requests.capture
    ))).
test(an_error_reply_has_three_parts, error(server_error(device_error, "Lamp é is out.", "Replace it."))) :-
    with_mock(vision,
              _{best:_{answers:[_{error:_{code:"device_error", message:"Lamp é is out.", hint:"Replace it."}}]}},
              Endpoint,
              with_client(Endpoint, [timeout(60), retries(60)], Client,
                          client_request(Client, best, _{}, _, []))).
test(the_client_works_on_after_an_error_reply, Code == unknown_operation) :-
    with_mock(vision, _{}, Endpoint, with_client(Endpoint, [timeout(60), retries(60)], Client, (
        catch(client_request(Client, dance, _{}, _, []), error(server_error(Code, _, _), _), true),
        client_request(Client, hello, _{}, _, [])
    ))).
test(a_wrong_field_is_named) :-
    with_mock(vision, _{}, Endpoint, with_client(Endpoint, [timeout(60), retries(60)], Client, (
        catch(client_request(Client, discard, _{picture:i1}, _, []), error(server_error(Code, Text, _), _), true),
        Code == bad_arguments,
        sub_string(Text, _, _, _, "picture")
    ))).
test(a_garbled_reply, error(server_error(bad_reply, _, _))) :-
    with_mock(vision, _{best:_{garble:1000}}, Endpoint,     % a server that starts slowly is asked more than once
              with_client(Endpoint, [timeout(60), retries(60)], Client,
                          client_request(Client, best, _{}, _, []))).
test(a_server_that_dies_is_noticed_by_the_alive_goal, Caught == server_gone) :-
    nb_setval(calls, 0),
    with_mock(vision, _{best:_{die:true}}, Endpoint,
              with_client(Endpoint, [timeout(600), alive(counted)], Client,
                          catch(client_request(Client, best, _{}, _, []), Caught, true))).
test(a_process_that_was_suspended_hears_what_was_answered_meanwhile, Status == "ok") :-
    nb_setval(suspended_s, 0),
    with_mock(vision, _{health:_{delay_s:1}}, Endpoint,
              with_client(Endpoint, [timeout(60), retries(0), alive(test_client:suspended)], Client, (
        client_request(Client, hello, _{}, _, []),
        nb_setval(suspended_s, 8),
        client_request(Client, health, _{}, Health, [timeout(5)]),
        Status = Health.status
    ))).

:- end_tests(client_and_server).

:- begin_tests(client_and_impostor).

test(a_retry_has_the_same_id_and_a_fresh_socket, Ids == [Id, Id, Id]) :-
    socket_endpoint(Endpoint),
    nb_setval(seen, 0),
    impostor(Endpoint, silent(3), Thread),
    with_client(Endpoint, [timeout(60), retries(300), alive(test_client:answers(Thread))], Client,
                catch(client_request(Client, hello, _{}, _, []), impostor_gone, true)),
    thread_join(Thread, exited(Ids)),
    Ids = [Id|_].
test(requests_count_up_and_clients_differ, true) :-
    socket_endpoint(Endpoint),
    impostor(Endpoint, obedient(4), Thread),
    Options = [timeout(60), alive(test_client:answers(Thread))],
    with_client(Endpoint, Options, A,
                with_client(Endpoint, Options, B,
                            ( client_request(A, hello, _{}, _, []),
                              client_request(A, hello, _{}, _, []),
                              client_request(B, hello, _{}, _, []),
                              catch(client_request(B, hello, _{}, _, []), impostor_gone, true)
                            ))),
    thread_join(Thread, exited(Ids)),
    length(Ids, Total),
    assertion(Total >= 4),
    sort(Ids, Distinct),
    assertion(length(Distinct, 4)).
test(stale_replies_are_dropped, A == 1) :-
    answered([ '{"v":1,"id":"other/1","ok":true,"result":{"a":2}}',
               '{"v":1,"id":"other/2","ok":false,"error":{"code":"x","message":"m"}}',
               good
             ], Result),
    A = Result.a.
test(an_error_without_id_is_ours, error(server_error(bad_message, "What?", ""))) :-
    answered(['{"v":1,"id":null,"ok":false,"error":{"code":"bad_message","message":"What?"}}'], _).
test(another_version, error(server_error(bad_reply, _, _))) :-
    answered(['{"v":2,"id":null,"ok":true,"result":{}}'], _).
test(a_reply_that_is_no_object, error(server_error(bad_reply, _, _))) :-
    answered(['[1]'], _).
test(a_reply_without_result, error(server_error(bad_reply, _, _))) :-
    answered([empty], _).
test(null_true_and_text, [A, B, C] == [null, true, "true"]) :-
    answered([odd], Result),
    _{a:A, b:B, c:C} :< Result.

answered(Replies, Result) :-
    socket_endpoint(Endpoint),
    impostor(Endpoint, replies(Replies), Thread),
    call_cleanup(with_client(Endpoint, [timeout(60)], Client,
                             client_request(Client, hello, _{}, Result, [])),
                 stop(Thread)).

stop(Thread) :-
    thread_signal(Thread, throw(stop)),
    thread_join(Thread, _).

replies(Replies, Request, Headers) :-
    maplist(header(Request.id), Replies, Headers).

header(Id, good, Header) =>
    format(string(Header), '{"v":1,"id":"~w","ok":true,"result":{"a":1}}', [Id]).
header(Id, empty, Header) =>
    format(string(Header), '{"v":1,"id":"~w","ok":true}', [Id]).
header(Id, odd, Header) =>
    format(string(Header), '{"v":1,"id":"~w","ok":true,"result":{"a":null,"b":true,"c":"true"}}', [Id]).
header(_, Text, Header) =>
    Header = Text.

silent(Most, _, Headers) :-
    counted_to(Most, Headers, []).

obedient(Most, Request, Headers) :-
    header(Request.id, good, Header),
    counted_to(Most, Headers, [Header]).

counted_to(Most, Headers, Otherwise) :-
    (   nb_current(requests, N0)
    ->  true
    ;   N0 = 0
    ),
    N is N0+1,
    nb_setval(requests, N),
    (   N >= Most
    ->  Headers = stop
    ;   Headers = Otherwise
    ).

:- end_tests(client_and_impostor).

:- begin_tests(client_alone).

test(nobody_there, error(bridge_timeout(Endpoint, hello, 0.2))) :-
    socket_endpoint(Endpoint),
    with_client(Endpoint, [timeout(0.2)], Client, client_request(Client, hello, _{}, _, [])).
test(a_malformed_endpoint, error(zmq_error('EINVAL', _))) :-
    with_client(nonsense, [], Client, client_request(Client, hello, _{}, _, [])).
test(sockets_are_given_back) :-
    zmq_open_sockets(Before),
    socket_endpoint(Endpoint),
    with_client(Endpoint, [timeout(0.1)], Client,
                catch(client_request(Client, hello, _{}, _, []), _, true)),
    zmq_open_sockets(After),
    assertion(After =< Before).
test(closing_twice) :-
    client_open('ipc:///tmp/x', Client, []),
    client_close(Client),
    client_close(Client).
test(a_closed_client, error(existence_error(bridge_client, Client))) :-
    client_open('ipc:///tmp/x', Client, []),
    client_close(Client),
    client_request(Client, hello, _{}, _, []).
test(a_wrong_option, error(type_error(_, soon))) :-
    client_open('ipc:///tmp/x', _, [timeout(soon)]).
test(opening_takes_nothing_from_the_random_generator, R1 == R2) :-
    set_random(seed(7)),
    random(R1),
    set_random(seed(7)),
    client_open('ipc:///tmp/x', Client, []),
    random(R2),
    client_close(Client).
test(a_timeout_reads_well) :-
    message_text(error(bridge_timeout('ipc:///tmp/v', capture, 2), _), Text),
    assertion(sub_string(Text, _, _, _, "The server at ipc:///tmp/v did not answer \"capture\" within 2 s.")).
test(an_error_reply_reads_well, Text == "The lamp is out. Replace it.") :-
    message_text(error(server_error(device_error, "The lamp is out.", "Replace it."), _), Text).
test(an_error_reply_without_hint_reads_well, Text == "The lamp is out.") :-
    message_text(error(server_error(device_error, "The lamp is out.", ""), _), Text).

message_text(Error, Text) :-
    '$messages':translate_message(Error, Lines, []),
    with_output_to(string(Raw), print_message_lines(current_output, '', Lines)),
    normalize_space(string(Text), Raw).

:- end_tests(client_alone).

:- begin_tests(client_events).

test(events_come_in_order, Events == ["target_moved"-1, "target_moved"-2]) :-
    with_mock(image, _{}, Endpoint, with_client(Endpoint, [timeout(60), retries(60)], Client, (
        client_request(Client, describe, _{}, Description, []),
        setup_call_cleanup(
            events_open(Description.events, Subscription),
            ( events_poll(Subscription, []),
              client_request(Client, move, _{range_m:0.5}, _, []),
              client_request(Client, move, _{range_m:0.4}, _, []),
              collected(Subscription, 2, Dicts)
            ),
            events_close(Subscription)),
        findall(Name-N, ( member(D, Dicts), _{event:Name, sequence:N} :< D ), Events)
    ))).
test(nobody_publishes, error(bridge_timeout(Endpoint, subscribe, 0.2))) :-
    socket_endpoint(Endpoint),
    events_open(Endpoint, _, [timeout(0.2)]).
test(closing_twice) :-
    socket_endpoint(Endpoint),
    zmq_socket(xpub, Pub, [xpub_welcome_msg("{\"v\":1,\"event\":\"welcome\",\"args\":{},\"sequence\":0}")]),
    zmq_bind(Pub, Endpoint),
    thread_create(events_open(Endpoint, _), Thread),
    zmq_receive(Pub, _, 60, octet),
    thread_join(Thread, true).

collected(Subscription, Wanted, Events) :-
    collected(Subscription, Wanted, [], Events).

collected(Subscription, Wanted, Before, Events) :-
    eventually(( events_poll(Subscription, More), More \== [] )),
    append(Before, More, All),
    (   length(All, N),
        N >= Wanted
    ->  Events = All
    ;   collected(Subscription, Wanted, All, Events)
    ).

:- end_tests(client_events).

:- begin_tests(client_curve).

test(the_right_keys, A == 1) :-
    zmq_curve_keypair(ServerPublic, ServerSecret),
    curve_asked(ServerPublic, ServerSecret, ServerPublic, 60, Result),
    A = Result.a.
test(the_wrong_key, error(bridge_refused(_))) :-
    zmq_curve_keypair(ServerPublic, ServerSecret),
    zmq_curve_keypair(Other, _),
    curve_asked(ServerPublic, ServerSecret, Other, 0.5, _).

curve_asked(ServerPublic, ServerSecret, ServerKey, Timeout, Result) :-
    thread_self(Me),
    thread_create(curve_server(Me, ServerPublic, ServerSecret), Thread),
    thread_get_message(listening(Endpoint)),
    zmq_curve_keypair(Public, Secret),
    call_cleanup(with_client(Endpoint, [timeout(Timeout), retries(20), curve(Public, Secret, ServerKey)], Client,
                             client_request(Client, hello, _{}, Result, [])),
                 ( thread_signal(Thread, throw(stop)),
                   thread_join(Thread, _)
                 )).

curve_server(Creator, Public, Secret) :-
    zmq_socket(router, Socket, [curve_server(true), curve_publickey(Public), curve_secretkey(Secret)]),
    zmq_bind(Socket, 'tcp://127.0.0.1:*'),
    zmq_endpoint(Socket, Endpoint),
    thread_send_message(Creator, listening(Endpoint)),
    zmq_receive(Socket, [Route, Text], infinite, octet),
    sub_string(Text, B, _, _, "prolog-"),
    sub_string(Text, B, _, 0, Rest),
    split_string(Rest, "\"", "", [Id|_]),
    format(string(Header), '{"v":1,"id":"~w","ok":true,"result":{"a":1}}', [Id]),
    zmq_send(Socket, [Route, Header], 1, octet),
    zmq_receive(Socket, _, infinite, octet).

test(who_listens_is_known_and_who_has_gone) :-
    zmq_socket(router, Socket, []),
    zmq_bind(Socket, 'tcp://127.0.0.1:*'),
    zmq_endpoint(Socket, Endpoint),
    forall(between(1, 1000, Look), assertion((Look > 0, somebody_listens(Endpoint)))),
    zmq_close(Socket),  % ZeroMQ gives its address up a little later
    eventually(\+ somebody_listens(Endpoint)).

:- end_tests(client_curve).
