:- module(test_indigolog_wrong,
          [ print_documented/0
          ]).
:- use_module(library(plunit)).
:- use_module(library(apply), [maplist/3, partition/4]).
:- use_module(library(filesex), [delete_directory_and_contents/1]).
:- use_module(library(lists), [append/3, member/2, nth1/3]).
:- use_module(library(readutil), [read_file_to_string/3]).
:- use_module('../../indigolog/tools/checks').
:- use_module('../../indigolog/indigolog').

/** <module> What docs/wrong_theories.md says is printed for each wrong theory is printed

In a theory of that page, a line `?- PROGRAM` is a program to check with it.
*/

% documented(-Title, -Theory, -Printed): lists of lines.
documented(Title, Theory, Printed) :-
    module_property(test_indigolog_wrong, file(Here)),
    file_directory_name(Here, Folder),
    atom_concat(Folder, '/../../docs/wrong_theories.md', File),
    read_file_to_string(File, Text, [encoding(utf8)]),
    split_string(Text, "\n", "", Lines),
    nth1(I, Lines, Heading),
    string_concat("## ", Title, Heading),
    length(Before, I),
    append(Before, Rest, Lines),
    block("```prolog", Rest, Theory, Rest1),
    block("```text", Rest1, Printed, _).

block(Fence, Lines, Block, Rest) :-
    append(_, [Fence|Lines1], Lines),
    !,
    append(Block, ["```"|Rest], Lines1),
    !.

% printed(+Theory, -Lines): what checking it prints, each with kind and line.
printed(Theory, Lines) :-
    partition([L]>>string_concat("?- ", _, L), Theory, Queries, Clauses),
    setup_call_cleanup(
        tmp_file_stream(File, Stream, [encoding(utf8), extension(pl)]),
        ( forall(member(Clause, Clauses), format(Stream, "~s~n", [Clause])),
          close(Stream),
          checked(File, Queries, Problems) ),
        delete_file(File)),
    maplist(line, Problems, Lines).

checked(File, Queries, Problems) :-
    catch(( load_theory(File),
            theory_problems(Problems0),
            findall(P, ( member(Query, Queries),
                         string_concat("?- ", Text, Query),
                         term_string(Program, Text),
                         program_problems(Program, Ps),
                         member(P, Ps) ),
                    Problems1),
            append(Problems0, Problems1, Problems) ),
          error(Formal, _),
          Problems = [Formal]).

line(problem(Kind, _, Line, What), Text) :-
    !,
    once(phrase(indigolog_problem_texts:problem(What), Parts)),
    rendered(Parts, Message),
    (   Line =:= 0
    ->  format(string(Text), "~w: ~s", [Kind, Message])
    ;   format(string(Text), "~w, line ~d: ~s", [Kind, Line, Message])
    ).
line(golog(Error), Text) :-
    without_file(Error, Error1),
    once(phrase(indigolog_messages:error_text(Error1), Parts)),
    rendered(Parts, Message),
    format(string(Text), "error: ~s", [Message]).

without_file(module_header(_, Own), Error) => Error = module_header('theory.pl', Own).
without_file(load(_, Count), Error) => Error = load(['theory.pl'], Count).
without_file(Error0, Error) => Error = Error0.

rendered(Parts, Text) :-
    with_output_to(string(Text0), print_message_lines(current_output, '', Parts)),
    split_string(Text0, "", "\n", [Text]).

%!  print_documented is det.
%
%   Print what each theory of the page gives now.

print_documented :-
    forall(documented(Title, Theory, _),
           ( printed(Theory, Lines),
             format("## ~s~n", [Title]),
             forall(member(Line, Lines), format("~s~n", [Line])) )).

:- begin_tests(wrong_theories).

test(printed, [forall(documented(Title, Theory, Expected)), true(Title-Lines == Title-Expected)]) :-
    printed(Theory, Lines).

test(a_value_is_shown_as_it_is,
     Line == "warning, line 3: fluent at is initially pi(2): the value pi(3) given here does not count") :-
    printed(["fun_fluent(at).", "initially(at, pi(2)).", "initially(at, pi(3))."], [Line]).

% Each round has its own.
test(bound_anew, [forall(member(Loop, ["for(I, [1, 2], note(I))", "for(I, L, note(I))", "star(pi(I, L, note(I)))",
                                       "while(n < 1, pi([(r(I), L), J], [?(J = I), note(J)]))",
                                       "while(n < 1, [?(maplist([I]>>(I > n), L)), note(n)])",
                                       "iconc(rpi((I, L), note(I)))", "star(?(some(I, member(I, L))))"])),
                  true(Lines == [])]) :-
    format(string(Clause), "proc(all(L), [~s, ?(L = [_|_])]).", [Loop]),
    printed(["fun_fluent(n).", "initially(n, 0).", "prim_action(note(_)).", "poss(note(_), true).", Clause], Lines).

% A value may have the name of the fluent whose value it is.
test(a_record_is_compared, [forall(member(Formula, ["at = at(_, _)", "at(_, 2) = at", "some([x, y], at = at(x, y))",
                                                    "and(S = at(1, 2), at = S)"])),
                            true(Lines == [])]) :-
    format(string(Clause), "proc(there, ~s).", [Formula]),
    printed(["fun_fluent(at).", "initially(at, at(1, 2)).", Clause], Lines).

% What binds a variable, or gives it a domain, comes before it is negated; a helper may be named nearly as an axiom; a
% variable may stand for a domain or a formula.
test(not_wrong, [forall(member(Clause, ["proc(go, pi(l, [?(lamp(l)), ?(neg(lit(l))), note(l)])).",
                                        "proc(go, pi((l, [a]), [?(neg(lit(l))), note(l)])).",
                                        "proc(dark, neg(some(l, lit(l)))).",
                                        "proc(dark, all(l, neg(lit(l)))).",
                                        "proc(dark, either). proc(either, or(lit(a), lit(b))). proc(go, ?(dark)).",
                                        "proc(go, run(note(a))). proc(run(E), E).",
                                        "proc(go, ?(post(a, _))). post(a, b).",
                                        "proc(go, pi(d, [?(d = [a, b]), for(l, d, note(l)), pi((k, d), note(k))])).",
                                        "proc(dark, some((d, [[a], [b]]), all((l, d), neg(lit(l))))).",
                                        "proc(go, pi(p, [?(member(p, [lit(a), lit(b)])), if(neg(p), note(p), [])])).",
                                        "proc(go, [for(p, [lit(a), lit(b)], ?(p))])."])),
                 true(Lines == [])]) :-
    printed(["rel_fluent(lit(_)).", "initially(lit(_), false).", "lamp(a).",
             "prim_action(note(_)).", "poss(note(_), true).", Clause], Lines).

% Of several files; what is included after its replacement is meant to stand back.
test(another_file_comes_first, Lines == ["warning, line 1: procedure ride/1: the clause in first.pl, line 2, comes first \
for the same calls: another name is needed"]) :-
    setup_call_cleanup(
        ( tmp_file(theory, Folder), make_directory(Folder) ),
        ( written(Folder, 'first.pl', "prim_action(up). poss(up, true).\nproc(ride(1), up).\n", First),
          written(Folder, 'included.pl', "proc(rise, [up, up]).\n", _),
          written(Folder, 'second.pl', "proc(ride(_), up).\nproc(rise, up).\n:- include('included.pl').\n", Second),
          load_theory([First, Second]),
          theory_problems(Problems),
          maplist(line, Problems, Lines) ),
        delete_directory_and_contents(Folder)).

written(Folder, Name, Text, File) :-
    atomic_list_concat([Folder, /, Name], File),
    setup_call_cleanup(open(File, write, Stream), write(Stream, Text), close(Stream)).

% A fluent without a value hides nothing else.
test(each_is_said, Lines == ["warning, line 1: fluent door(b) has no initial value: initially(door(b), Value) gives it one",
                             "error, line 3: causes_val/3 has the wrong number of arguments: it is causes_val/4"]) :-
    printed(["fun_fluent(door(D)) :- member(D, [a, b]). initially(door(a), shut).", "prim_action(up). poss(up, true).",
             "causes_val(up, door(a), open)."], Lines).

test(several_are_right, Line == "error, line 1: senses/3 has the wrong number of arguments: it is senses/2 or senses/5") :-
    printed(["senses(a, b, c)."], [Line]).

% What is called may come with the file, be declared and asserted later, or belong to a library.
test(defined_somewhere, [forall(member(Clause, ["poss(up, true) :- top(N), succ(_, N).", "poss(up, true) :- lists:last([1], _).",
                                                "poss(up, true) :- ( \\+ kept(_) -> true ; top(_) )."])),
                         true(Lines == [])]) :-
    printed([":- dynamic kept/1.", "top(1). prim_action(up).", Clause], Lines).

test(directive, [forall(member(Directive-Missing, [ "dir(indigolog_plain, F), consult(F)"-predicate(dir/2),
                                                    "['indigolog-vanilla']"-file('indigolog-vanilla'),
                                                    "include(kplanner)"-file(kplanner) ])),
                 true(Said-Error == [golog(directive(Missing))]-load(1))]) :-
    format(string(Line), ":- ~s.", [Directive]),
    nb_setval(said, []),
    setup_call_cleanup(
        asserta((user:message_hook(Term, error, _) :- nb_getval(said, Before), nb_setval(said, [Term|Before])), Hook),
        printed([Line], [_]),
        erase(Hook)),
    nb_getval(said, Said),
    length(Said, N),
    Error = load(N).

test(all_are_wrong, true(Count >= 25)) :-
    findall(T, ( documented(T, _, Printed), Printed \== [] ), Titles),
    length(Titles, Count).

:- end_tests(wrong_theories).
