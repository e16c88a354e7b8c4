:- module(test_session_display, []).
:- use_module(library(plunit)).
:- use_module('../../../session/display/display').
:- use_module('../../../session/display/outcome', [advised/4, merit_words/2]).

/** <module> What a session says of itself */

shown(Message, Text) :-
    phrase(prolog:message(session(Message)), Parts),
    with_output_to(string(Text0), print_message_lines(current_output, '', Parts)),
    split_string(Text0, "", "\n", [Text]).

% said(-Error, -Sentence): of a server that was lost in this way
said(error(server_died(vision_server, killed(9), "", 'vision_server.log'), _),
     "  the vision server was killed, by signal 9: it is brought back, and the session goes on (1 of at most 5 times)").
said(error(server_error(timeout, "It did not answer within 30 s.", "Wait."), _),
     "  It did not answer within 30 s: it is waited for and asked again, and the session goes on (1 of at most 5 times)").
said(error(server_error(no_session, "There is no session on this connection.", "Start."), _),
     "  There is no session on this connection: it is told of the session again, and the session goes on (1 of at most 5 times)").

:- begin_tests(display).

test(what_is_done_about_a_server_is_true, [forall(said(Error, Sentence)), true(Text == Sentence)]) :-
    shown(brought_back(Error, 1, 5), Text).
test(what_a_server_cannot_use_is_said_in_its_own_words, true(Text == "image_server: model part.step: unknown kind\n")) :-
    phrase(prolog:error_message(server_died(image_server, exit(2), "image_server: model part.step: unknown kind", 'no.log')), Parts),
    with_output_to(string(Text), print_message_lines(current_output, '', Parts)).
test(the_target_is_named_where_it_is_known, [forall(member(Shows-Begin, [ target(cube)-"Session: greedy on cube, seed 1\n",
                                                                         stack(images)-"Session: greedy on the stack images, seed 1\n",
                                                                         served-"Session: greedy, seed 1\n" ])),
                                              true(sub_string(Text, 0, _, _, Begin))]) :-
    shown(begin(plan{controller:greedy, shows:Shows, seed:1, program:session}, run), Text).
test(who_is_waited_for, true(Text == "  waiting for the servers to start ...")) :-
    shown(waiting(vision_server, start), Text).
test(a_page_that_was_not_written_is_by_the_command_that_is_said,
     true(Text == "report.html was not written (timeout); try: .venv/bin/python -m report 'my run'")) :-
    shown(no_report('my run', timeout), Text).
test(small_merits_are_told_apart, [forall(member(Px-Expected, [0-'0.00', 0.00384-'0.0038', 0.1-'0.10', 12.345-'12.35'])),
                                   true(Words == Expected)]) :-
    merit_words(Px, Words).
test(more_images_are_advised_where_an_approach_was_allowed_no_more_at_its_last_hold_point,
     [forall(member(Images-Advice, [19-[], 20-['more than 10 images (--max-iterations)']])), true(Helps == Advice)]) :-
    findall(step{hold:1}, between(1, Images, _), Steps),
    advised(images(10, inf), [], result{status:exhausted, controller:heuristic, pose:none, score:0.1, ambiguity:0.0, merit_px:9, threshold_px:1,
                       iterations:Images, steps:Steps}, Advised),
    get_dict(advice, Advised, Helps).
test(of_how_many_images_the_pose_is_is_said_where_a_new_set_was_begun,
     [forall(member(Size-Expected, [2-"Pose found after 2 images, 2 kept, 1.0 s", 1-"Pose found after 2 images, 2 kept, the pose from the last 1, 1.0 s"])),
      true(sub_string(Text, 0, _, _, Expected))]) :-
    Result = result{status:converged, iterations:2, kept:[i1, i2], seconds:seconds{total:1.0}, steps:[step{set_size:Size}],
                    pose:pose{translation:[0, 0, 1], rotation_vector:[0, 0, 0]}, merit_px:0.1, rms_px:0.1, threshold_px:1.2},
    phrase(prolog:message(session_outcome(Result)), Parts),
    with_output_to(string(Text), print_message_lines(current_output, '', Parts)).
test(how_a_round_target_is_turned_is_said_to_be_open, true(sub_string(Text, _, _, _, Expected))) :-
    Expected = "\n  no image clearly tells how it is turned about its axis 0.00 0.00 1.00",
    Result = result{status:converged, iterations:1, kept:[i1], seconds:seconds{total:1.0}, steps:[step{set_size:1}], free:[[0.0, 0.0, 1.0]],
                    pose:pose{translation:[0, 0, 1], rotation_vector:[0, 0, 0]}, merit_px:0.1, rms_px:0.1, threshold_px:1.2},
    phrase(prolog:message(session_outcome(Result)), Parts),
    with_output_to(string(Text), print_message_lines(current_output, '', Parts)).
test(another_view_may_help_where_another_pose_holds_this_one_back,
     [forall(member(Images-Chance-Help, [3-0.1-'another view', 3-0.0-'a strategy', 1-0.1-'a strategy', 10-0.1-'more than'])),
      true(sub_atom(First, 0, _, _, Help))]) :-
    Score is 0.93 / (1 + Chance),
    Merit is 15 * (1 - Score),
    advised(images(10, inf), [], result{status:exhausted, pose:pose{}, score:Score, ambiguity:Chance, merit_px:Merit, threshold_px:1.2,
                       iterations:Images}, Advised),
    get_dict(advice, Advised, [First|_]).
test(no_more_images_are_advised_than_a_stack_has,
     [forall(member(Images-Recorded-Chance-Help, [ 10-10-0.0-'a stack of more frames, or of frames under other lights: this one has 10 frames',
                                                   4-4-0.0-'a stack of more frames', 12-10-0.0-'a stack of more frames',
                                                   10-10-0.1-'another view', 10-11-0.0-'more than 10 images', 4-11-0.0-'a strategy' ])),
      true(sub_atom(First, 0, _, _, Help))]) :-
    Score is 0.93 / (1 + Chance),
    Merit is 15 * (1 - Score),
    advised(images(10, Recorded), [], result{status:exhausted, pose:pose{}, score:Score, ambiguity:Chance, merit_px:Merit,
                                             threshold_px:1.2, iterations:Images}, Advised),
    get_dict(advice, Advised, [First|_]).
test(black_images_are_said_to_be_so,
     [forall(member(Second-Begin, [0.001-'light: every image is black', 0.1-'is the target in view'])),
      true(sub_atom(First, 0, _, _, Begin))]) :-
    advised(images(10, inf), [reading(s, statistics(0, 0, 1, 0, unknown)), reading(s, statistics(0, Second, 1, 0, unknown))],
            result{status:exhausted, pose:null, iterations:2, controller:heuristic,
                   steps:[step{decision:discard, pose:null}, step{decision:discard, pose:null}]}, Advised),
    get_dict(advice, Advised, [First|_]).
test(many_lights_are_counted, true(sub_string(Text, _, _, _, "`position` of 40 lights is not told"))) :-
    findall(Name, ( between(1, 40, N), atom_concat(ring, N, Name) ), Names),
    shown(unknown_places(Names), Text).

:- end_tests(display).
