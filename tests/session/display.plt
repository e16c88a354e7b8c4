:- module(test_session_display, []).
:- use_module(library(plunit)).
:- use_module('../../session/display').

/** <module> What a session says of itself */

% said(-Error, -Sentence): of a server that was lost in this way
said(error(server_died(vision_server, killed(9), "", 'vision_server.log'), _),
     "  the vision_server ended by itself (killed(9)): it is brought back, and the session goes on (1 of at most 5 times)").
said(error(server_error(timeout, "It did not answer within 30 s.", "Wait."), _),
     "  It did not answer within 30 s: it is waited for and asked again, and the session goes on (1 of at most 5 times)").
said(error(server_error(no_session, "There is no session on this connection.", "Start."), _),
     "  There is no session on this connection: it is told of the session again, and the session goes on (1 of at most 5 times)").

:- begin_tests(display).

test(what_is_done_about_a_server_is_true, [forall(said(Error, Sentence)), true(Text == Sentence)]) :-
    phrase(prolog:message(session(brought_back(Error, 1, 5))), Parts),
    with_output_to(string(Text0), print_message_lines(current_output, '', Parts)),
    split_string(Text0, "", "\n", [Text]).

:- end_tests(display).
