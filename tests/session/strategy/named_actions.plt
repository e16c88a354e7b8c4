:- module(test_session_named_actions, []).
:- use_module(library(plunit)).
:- use_module('../../../indigolog/indigolog', [load_theory/1]).
:- use_module('../../../session/strategy/named_actions').
:- use_module('../../../session/strategy/strategy_file').

/** <module> What a strategy names is looked at where it stands in a program, and told with its line */

% The first message of Goal, which is called with a file of these lines; the file is S there.
told(Lines, Goal, Message) :-
    tmp_file_stream(File, Stream, [extension(pl)]),
    format(Stream, "fun_fluent(mine).~ninitially(mine, 0).~n~s~n", [Lines]),
    close(Stream),
    load_theory(File),
    call_cleanup(catch(( call(Goal, File), Said = "" ), error(usage_error(Said), _), true), delete_file(File)),
    atomics_to_string([Said], Text),
    atomic_list_concat(Parts, File, Text),
    atomic_list_concat(Parts, 'S', Message).

knows([matcher]).

parameters(File) :-
    check_parameters(File, knows).

:- begin_tests(named_actions).

chosen("proc(control, [\n choose(s)]).", 'S:4: choose(s): s is no fluent').
chosen("proc(control, pi(s, [\n choose(s)])).", 'S:4: choose(s): pi binds it, and nothing before').
chosen("proc(control, rpi(S, conc([],\n choose(S)))).", 'S:4: choose(_): pi binds it').
chosen("proc(control, [pi(s, [?(p(s)), choose(s)]),\n choose(s)]).", 'S:4: choose(s): s is no fluent').
chosen("proc(control, [pi(s, [?(p(s)), choose(s)]),\n pi(s, choose(s))]).", 'S:4: choose(s): pi binds it').
chosen("proc(control, twice(if(mine = 1, [],\n choose(s)))).\nproc(twice(P), [P, P]).", 'S:4: choose(s): s is no fluent').
chosen("proc(one(x), [])\n :- true.\nproc(one(_),\n choose(s)) :- true.", 'S:6: choose(s): s is no fluent').

test(without_settings, [forall(chosen(Lines, Begin)), true(sub_atom(Message, 0, _, _, Begin))]) :-
    told(Lines, check_chosen, Message).

has_value("proc(control, [choose(mine), for(k, [mine], choose(k)), pi((s, [mine]), choose(s))]).").
has_value("proc(control, pi(s, [one(s), choose(s)])).\nproc(one(S), choose(S)).").
has_value("proc(control, pi(s, interrupt(t, p(t), [choose(t)]))).").
has_value("proc(control, ?(member(choose(s), [choose(s)]))).").
has_value("poss(choose(s), true).\nproc(control, []).").

test(with_settings, [forall(has_value(Lines)), true(Message == 'S')]) :-
    told(Lines, [File]>>( check_chosen(File), throw(error(usage_error(File), _)) ), Message).

set("set_parameter(macher, 1)", 'S:4: there is no vision parameter macher; there are matcher. Did you mean matcher?').
set("pi(name, [?(name = matcher), set_parameter(name, 1)])", '').
set("[?(p(set_parameter(macher, 1))), set_parameter(matcher, 1)]", '').
set("[pi(macher, ?(p(macher))), set_parameter(macher, 1)]", 'S:4: there is no vision parameter macher; there are matcher. Did you mean matcher?').

test(parameters, [forall(set(Program, Expected)), true(Message == Expected)]) :-
    format(string(Lines), "proc(control,\n ~s).", [Program]),
    told(Lines, parameters, Message).

test(where_it_may_be, [forall(member(Terms-Expected, [ [a]-'S:3', [nowhere, b]-'S, line 3, 5', [_, nowhere]-'S' ])), true(Place == Expected)]) :-
    told("proc(p, [a, b]).\n\nproc(q, [b]).",
         [File]>>( place_of(File, Terms, Said), throw(error(usage_error(Said), _)) ), Place).

test(where_an_action_is_done, true(Place == 'S:5')) :-
    told("prim_action(a).\nposs(a, true).\nproc(p, [a]) :- true.",
         [File]>>( place_of(File, [a], Said), throw(error(usage_error(Said), _)) ), Place).

test(where_any_may_be, true(Place == 'S, line 3, 4, 5')) :-
    told("proc(p, a).\nproc(q, b).\nproc(r, a).",
         [File]>>( places_of(File, [b, a], Said), throw(error(usage_error(Said), _)) ), Place).

:- end_tests(named_actions).
