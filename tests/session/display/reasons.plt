:- module(test_session_reasons, []).
:- use_module(library(plunit)).
:- use_module(library(lists)).
:- use_module('../../../domain/testing/simulated_world').
:- use_module('../../../indigolog/indigolog').
:- use_module('../../../session/display/explanation').
:- use_module('../../../session/display/reasons').

/** <module> Reasons of decisions, as they follow from the situation */

chosen(Options, Program, Reason, Dict) :-
    chosen(Options, Program, Reason, Device, _),
    reason_dict(Device, Reason, Dict).

chosen(Options, Program, Reason, Device, Text) :-
    in_world(Options, informed, [connect|Program], final, Situation),
    situation_history(Situation, [choose(Settings)|_]),
    decision_reason(choose(Settings), Situation, Reason),
    fluent_value(device, Situation, Device),
    once(phrase(explanation(Device, Reason), Parts)),
    with_output_to(string(Text), print_message_lines(current_output, '', Parts)).

:- begin_tests(reasons).

test(what_was_foreseen_to_add_most_is_the_reason, Settings-Bits-Line == settings([7, 1, 0], 0.0166667, 4.0)-2.5-3) :-
    chosen([], [choose_promising, take_image, measure, keep_image, choose_informative],
           chosen(Settings, adds(Bits, Line, _), _, 195, left_out(0, 0)), Dict),
    assertion(Dict.chosen.bits == 2.5),
    assertion(\+ get_dict(promise, Dict.chosen, _)).
test(states_like_unfavourable_ones_are_left_out) :-
    chosen([], [ choose_promising, take_image, measure, keep_image, avoid(state(bright, even, 0)), choose_informative ],
           chosen(_, adds(_, _, _), _, Count, left_out(0, LeftOut)), _),
    assertion(( LeftOut > 0, LeftOut < Count )).
test(what_was_foreseen_before_an_image_is_no_reason_after_it) :-
    chosen([], [ choose_promising, take_image, measure, keep_image, choose_informative, take_image, measure, keep_image,
                 choose(settings([7, 1, 0], 0.0166667, 4.0)) ],
           chosen(_, Why, _, _, _), _),
    assertion(\+ Why = adds(_, _, _)).
test(promise_is_the_reason_where_nothing_is_foreseen) :-
    chosen([nothing_foreseen], [choose_promising, take_image, measure, keep_image, choose_informative],
           chosen(_, why(_, Promise, _), _, _, _), Dict),
    assertion(Dict.chosen.promise =:= Promise),
    assertion(Dict.chosen.promise =:= Dict.chosen.information + Dict.chosen.likelihood).
test(what_was_not_chosen_for_its_promise_is_held_against_no_other) :-
    chosen([], [choose_safe], _, _, Safe),
    assertion(sub_string(Safe, _, _, _, "not for its promise")),
    assertion(\+ sub_string(Safe, _, _, _, "rather than")),
    chosen([], [choose_promising], _, _, Promising),
    assertion(sub_string(Promising, _, _, _, "rather than")).
test(it_is_counted_why_the_rest_was_left_out) :-
    chosen([nothing_foreseen],
           [ choose_promising, take_image, measure, keep_image, avoid(state(off, none, 0)), choose_informative ],
           chosen(_, why(_, _, _), Best, Count, left_out(Alike, Unfavourable)), Dict),
    assertion(length(Best, 5)),
    assertion(( Alike > 0, Unfavourable > 0, Alike + Unfavourable < Count )),
    assertion(Dict.left_out_alike + Dict.left_out_unfavourable =:= Alike + Unfavourable).

:- end_tests(reasons).
