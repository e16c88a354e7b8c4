:- module(test_zmq, []).
:- use_module(library(plunit)).
:- use_module(library(apply)).
:- use_module(library(lists)).
:- use_module(library(process)).
:- use_module('../../bridge/prolog/zmq').
:- use_module(fixtures).

pair_of_sockets(Router, Dealer) :-
    socket_endpoint(Endpoint),
    zmq_socket(router, Router, []),
    zmq_bind(Router, Endpoint),
    zmq_socket(dealer, Dealer, []),
    zmq_connect(Dealer, Endpoint).

:- begin_tests(zmq_messages).

test(multipart_there_and_back, Back == ["é→𝄞", "", "b"]) :-
    pair_of_sockets(Router, Dealer),
    zmq_send(Dealer, ["é→𝄞", '', [0'b]], 1),
    zmq_receive(Router, [Route|Frames], 60, octet),
    zmq_send(Router, [Route|Frames], 1, octet),
    zmq_receive(Dealer, Back, 60).
test(octets_are_bytes, Codes == [0, 255, 10]) :-
    pair_of_sockets(Router, Dealer),
    zmq_send(Dealer, [[0, 255, 10]], 1, octet),
    zmq_receive(Router, [_, Frame], 60, octet),
    string_codes(Frame, Codes).
test(header_leaves_pixels_alone, Frames == ["{}"]) :-
    pair_of_sockets(Router, Dealer),
    zmq_send(Dealer, ["x"], 1),
    zmq_receive(Router, [Route, _], 60, octet),
    zmq_send(Router, [Route, "{}", [255, 254]], 1, octet),
    zmq_receive(Dealer, Frames, 60, header).
test(a_frame_that_is_not_utf8, error(domain_error(utf8_frame, 0))) :-
    not_utf8([0'a, 0xc3]).
test(overlong_utf8, error(domain_error(utf8_frame, 0))) :-
    not_utf8([0xc0, 0x80]).
test(surrogate_in_utf8, error(domain_error(utf8_frame, 0))) :-
    not_utf8([0xed, 0xa0, 0x80]).
test(no_message_in_time, fail) :-
    pair_of_sockets(Router, _),
    zmq_receive(Router, _, 0.05).
test(no_peer_in_time, fail) :-
    zmq_socket(push, Push, []),
    zmq_send(Push, ["x"], 0.05).
test(too_many_frames, error(resource_error(zmq_frames))) :-
    pair_of_sockets(_, Dealer),
    numlist(1, 65, Frames0),
    maplist([N, F]>>number_string(N, F), Frames0, Frames),
    zmq_send(Dealer, Frames, 1).
test(no_frames, error(domain_error(non_empty_list, []))) :-
    pair_of_sockets(_, Dealer),
    zmq_send(Dealer, [], 1).
test(a_negative_timeout, error(domain_error(timeout, -1))) :-
    pair_of_sockets(_, Dealer),
    zmq_receive(Dealer, _, -1).
test(a_peer_that_died, fail) :-
    socket_endpoint(Endpoint),
    zmq_socket(dealer, Dealer, []),
    format(atom(Goal),
           '(zmq_socket(router,S,[]),zmq_bind(S,~q),zmq_receive(S,_,infinite),halt(0))', [Endpoint]),
    with_child(Goal, Process, _,
               ( zmq_connect(Dealer, Endpoint),
                 zmq_send(Dealer, ["x"], 1),
                 process_wait(Process, exit(0))
               )),
    zmq_receive(Dealer, _, 0.2).

test(a_monitor_that_has_ended_holds_nobody_up, Text == "x") :-
    pair_of_sockets(Router, Dealer),
    zmq_endpoint(Router, Endpoint),
    zmq_socket(dealer, Monitored, []),
    zmq_monitored(Monitored, Monitor, is_zmq_socket(Monitor)),
    zmq_connect(Monitored, Endpoint),  % its event has nobody to go to
    zmq_send(Monitored, ["monitored"], 60),
    zmq_receive(Router, _, 60, octet),
    zmq_send(Dealer, ["x"], 1),
    zmq_receive(Router, [_, Text], 60, octet).

not_utf8(Codes) :-
    pair_of_sockets(Router, Dealer),
    zmq_set(Router, router_mandatory, true),
    zmq_send(Dealer, ["x"], 1),
    zmq_receive(Router, [Route, _], 60, octet),
    zmq_send(Router, [Route, Codes], 1, octet),
    zmq_receive(Dealer, _, 60).

test(an_ipv6_address, [condition(exists_file('/proc/net/if_inet6')), true(Frame == "a")]) :-
    zmq_socket(router, Router, []),
    zmq_bind(Router, 'tcp://[::1]:*'),
    zmq_endpoint(Router, Endpoint),
    zmq_socket(dealer, Dealer, []),
    zmq_connect(Dealer, Endpoint),
    zmq_send(Dealer, ["a"], 1),
    zmq_receive(Router, [_, Frame], 60, octet).

:- end_tests(zmq_messages).

:- begin_tests(zmq_errors).

test(address_in_use, error(zmq_error('EADDRINUSE', _), context(bridge_zmq:zmq_bind/2, Endpoint))) :-
    zmq_socket(router, A, []),
    zmq_bind(A, 'tcp://127.0.0.1:*'),
    zmq_endpoint(A, Endpoint),
    zmq_socket(router, B, []),
    zmq_bind(B, Endpoint).
test(malformed_endpoint, error(zmq_error('EINVAL', "Invalid argument"), context(bridge_zmq:zmq_connect/2, nonsense))) :-
    zmq_socket(dealer, S, []),
    zmq_connect(S, nonsense).
test(wrong_state, error(zmq_error('EFSM', _), context(bridge_zmq:zmq_receive/3, _))) :-
    socket_endpoint(Endpoint),
    zmq_socket(req, S, []),
    zmq_connect(S, Endpoint),
    zmq_receive(S, _, 0).
test(option_refused, error(zmq_error('EINVAL', _), context(bridge_zmq:zmq_set/3, _))) :-
    zmq_socket(dealer, S, []),
    zmq_set(S, subscribe, "").
test(unknown_type, error(domain_error(zmq_socket_type, dear))) :-
    zmq_socket(dear, _, []).
test(unknown_option, error(domain_error(zmq_option, colour))) :-
    zmq_socket(dealer, _, [colour(red)]).
test(key_too_short, error(domain_error(z85_key_of_40_characters, curve_secretkey))) :-
    zmq_socket(dealer, _, [curve_secretkey(short)]).
test(no_socket, error(type_error(zmq_socket, foo))) :-
    zmq_send(foo, ["x"], 1).
test(closed_socket, error(existence_error(zmq_socket, S))) :-
    zmq_socket(dealer, S, []),
    zmq_close(S),
    zmq_send(S, ["x"], 1).
test(closing_twice, Open == false) :-
    zmq_socket(dealer, S, []),
    zmq_close(S),
    zmq_close(S),
    ( is_zmq_socket(S) -> Open = true ; Open = false ).
test(an_error_reads_well, Text == "bridge_zmq:zmq_bind/2: ZeroMQ refused: No such file or directory (ENOENT) (ipc:///no/where)") :-
    zmq_socket(router, S, []),
    catch(zmq_bind(S, 'ipc:///no/where'), Error, true),
    message_to_codes(Error, Text).

message_to_codes(Error, Text) :-
    '$messages':translate_message(Error, Lines, []),
    with_output_to(string(Raw), print_message_lines(current_output, '', Lines)),
    normalize_space(string(Text), Raw).

:- end_tests(zmq_errors).

:- begin_tests(zmq_lifetime).

test(opened_and_closed) :-
    zmq_open_sockets(Before),
    forall(between(1, 10000, _),
           ( zmq_socket(dealer, S, []),
             zmq_close(S)
           )),
    zmq_open_sockets(After),
    assertion(After =< Before).
test(opened_and_lost) :-
    forall(between(1, 10000, _), zmq_socket(dealer, _, [])),
    collected_down_to(99).
test(options_refused_leave_no_socket) :-
    zmq_open_sockets(Before),
    catch(zmq_socket(dealer, _, [colour(red)]), _, true),
    zmq_open_sockets(After),
    assertion(After =< Before).
test(another_thread_may_collect, [setup(( garbage_collect_atoms, zmq_open_sockets(Before) ))]) :-
    forall(between(1, 50, _), zmq_socket(dealer, _, [])),
    Most is Before+1,
    in_thread(( collected_down_to(Most), Done = true ), Done).
test(what_is_in_use_is_not_collected, Text == "x") :-
    pair_of_sockets(Router, Dealer),
    in_thread(garbage_collect_atoms, _),
    zmq_send(Dealer, ["x"], 1),
    zmq_receive(Router, [_, Text], 60, octet).
test(other_threads_keep_off, error(permission_error(use_in_other_thread, zmq_socket, S))) :-
    zmq_socket(dealer, S, []),
    in_thread(catch(zmq_send(S, ["x"], 0), Error, true), Error),
    throw(Error).
test(sockets_of_a_thread_that_ended_are_garbage) :-
    zmq_open_sockets(Before),
    in_thread(( numlist(1, 100, Ns),
                maplist([_, S]>>zmq_socket(dealer, S, []), Ns, _)
              ), _),
    collected_down_to(Before).
test(threads_with_sockets_of_their_own, Sums == [5050, 5050, 5050, 5050]) :-
    findall(Thread,
            ( between(1, 4, _), thread_create(( sum_by_messages(Sum), thread_exit(Sum) ), Thread) ),
            Threads),
    maplist([Thread, Sum]>>thread_join(Thread, exited(Sum)), Threads, Sums).

%   What is lost is collected. A collection that the system's own thread is at makes one that is asked for do nothing.
collected_down_to(Most) :-
    eventually(( garbage_collect_atoms, zmq_open_sockets(Left), Left =< Most )).

in_thread(Goal, Result) :-
    thread_create(( call(Goal), thread_exit(Result) ), Thread),
    thread_join(Thread, exited(Result)).

sum_by_messages(Sum) :-
    pair_of_sockets(Router, Dealer),
    findall(N,
            ( between(1, 100, I),
              number_string(I, Text),
              zmq_send(Dealer, [Text], 1),
              zmq_receive(Router, [_, Back], 60, octet),
              number_string(N, Back)
            ),
            Ns),
    sum_list(Ns, Sum).

:- end_tests(zmq_lifetime).

:- begin_tests(zmq_interrupts).

test(without_stops_it_comes_to_what_the_goal_comes_to, [X, Caught] == [1, thrown]) :-
    zmq_without_stops(X = 1),
    \+ zmq_without_stops(fail),
    catch(zmq_without_stops(throw(thrown)), Caught, true).
test(afterwards_they_come_again, Blocked == 0) :-
    zmq_without_stops(true),
    read_file_to_string('/proc/thread-self/status', Status, []),
    once(sub_string(Status, At, _, _, "SigBlk:\t")),
    Start is At+8,
    sub_string(Status, Start, 16, _, Mask),
    string_concat("0x", Mask, Number),
    number_string(Bits, Number),
    Blocked is Bits /\ 0x4002.         % SIGINT and SIGTERM
test(a_signal_ends_the_wait, Status == exception(enough)) :-
    thread_self(Me),
    thread_create(( zmq_socket(pull, S, []),
                    thread_send_message(Me, waiting),
                    zmq_receive(S, _, infinite)
                  ), Thread),
    thread_get_message(waiting),
    thread_signal(Thread, throw(enough)),
    thread_join(Thread, Status).
test(a_signal_that_does_nothing_does_not, Status == true) :-
    socket_endpoint(Endpoint),
    thread_self(Me),
    thread_create(( zmq_socket(pull, S, []),
                    zmq_bind(S, Endpoint),
                    thread_send_message(Me, waiting),
                    zmq_receive(S, ["x"], infinite)
                  ), Thread),
    thread_get_message(waiting),
    thread_signal(Thread, true),
    zmq_socket(push, Push, []),
    zmq_connect(Push, Endpoint),
    zmq_send(Push, ["x"], 60),
    thread_join(Thread, Status).
test(ctrl_c_while_waiting, Status == exit(130)) :-
    child_ended_by(int,
                   '(assertz((stop(_):-throw(interrupted))),on_signal(int,_,stop),zmq_socket(pull,S,[]),\c
                     catch((writeln(ready),flush_output,zmq_receive(S,_,infinite)),interrupted,halt(130)))',
                   Status).
test(sigterm_with_a_handler_that_halts, Status == exit(143)) :-
    child_ended_by(term,
                   '(assertz((bye(_):-halt(143))),on_signal(term,_,bye),zmq_socket(pull,S,[]),writeln(ready),\c
                     flush_output,zmq_receive(S,_,infinite))',
                   Status).
test(halt_with_open_sockets_and_messages_under_way, Status == exit(0)) :-
    child('(zmq_socket(dealer,S,[]),zmq_connect(S,\'tcp://127.0.0.1:9\'),\c
            forall(between(1,100,_),zmq_send(S,[x],1)),nb_setval(keep,S),halt(0))', Status).
test(halt_while_another_thread_waits, Status == exit(0)) :-
    child('(thread_self(Me),thread_create((zmq_socket(pull,S,[]),thread_send_message(Me,here),\c
            zmq_receive(S,_,infinite)),_),thread_get_message(here),sleep(0.1),halt(0))', Status).

child(Goal, Status) :-
    with_child(Goal, Process, _, process_wait(Process, Status, [timeout(240)])).

child_ended_by(Signal, Goal, Status) :-
    with_child(Goal, Process, Out,
               ( read_line_to_string(Out, "ready"),
                 process_kill(Process, Signal),
                 process_wait(Process, Status, [timeout(240)])
               )).

:- end_tests(zmq_interrupts).

:- begin_tests(zmq_curve).

test(the_right_keys, Text == "secret") :-
    curve_talk(ServerPublic, ServerPublic, 60, Text).
test(the_wrong_server_key, fail) :-
    zmq_curve_keypair(Other, _),
    curve_talk(_, Other, 0.3, _).
test(no_keys, fail) :-
    curve_server(_, Server, Endpoint),
    zmq_socket(dealer, Client, []),
    zmq_connect(Client, Endpoint),
    zmq_send(Client, ["secret"], 1),
    zmq_receive(Server, _, 0.3, octet).
test(keys_are_z85_text, [Length, Kind] == [40, true]) :-
    zmq_curve_keypair(Public, Secret),
    string_length(Secret, Length),
    ( Public \== Secret -> Kind = true ; Kind = false ).

curve_talk(ServerPublic, ServerKey, Timeout, Text) :-
    curve_server(ServerPublic, Server, Endpoint),
    zmq_curve_keypair(Public, Secret),
    zmq_socket(dealer, Client,
               [ curve_publickey(Public), curve_secretkey(Secret), curve_serverkey(ServerKey) ]),
    zmq_connect(Client, Endpoint),
    zmq_send(Client, ["secret"], 1),
    zmq_receive(Server, [_, Text], Timeout, octet).

curve_server(Public, Server, Endpoint) :-
    zmq_curve_keypair(Public, Secret),
    zmq_socket(router, Server, [curve_server(true), curve_publickey(Public), curve_secretkey(Secret)]),
    zmq_bind(Server, 'tcp://127.0.0.1:*'),
    zmq_endpoint(Server, Endpoint).

:- end_tests(zmq_curve).
