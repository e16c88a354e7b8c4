:- module(benchmark_golog, [main/0]).
/** <module> What steps of Golog programs cost

    swipl benchmarks/golog.pl
    swipl benchmarks/golog.pl smallest
    swipl benchmarks/golog.pl memory offline|online

One JSON object a line.  Each time is processor time, the least of a few runs after one that
does not count.  `smallest` leaves all but the smallest program of each kind out, and times each once.
`memory` is the most that a process held in memory which did a hundred thousand steps.
*/

:- use_module(library(apply), [foldl/4]).
:- use_module(library(http/json), [json_write_dict/3]).
:- use_module(library(lists), [member/2, memberchk/2, min_list/2]).
:- use_module('../indigolog/indigolog').

:- initialization(main, main).

main :-
    current_prolog_flag(argv, Argv),
    (   Argv == []
    ->  times(all)
    ;   Argv == [smallest]
    ->  times(smallest)
    ;   Argv = [memory, Mode],
        memberchk(Mode, [offline, online])
    ->  memory(Mode)
    ;   format(user_error, "usage: swipl benchmarks/golog.pl [smallest | memory offline|online]~n", []),
        ( Argv == ['--help'] -> halt(0) ; halt(2) )
    ).

memory(Mode) :-
    theory(count, none),
    executed(Mode, count(100_000)),
    format(string(Label), "golog/~w/count/count(100000)/memory", [Mode]),
    high_water_mark(Kilobytes),
    Value is Kilobytes/1024,
    show(Label, Value, "MB", _{}).

% As Linux tells it.
high_water_mark(Kilobytes) :-
    setup_call_cleanup(open('/proc/self/status', read, In),
                       read_string(In, _, Status),
                       close(In)),
    split_string(Status, "\n", "", Lines),
    member(Line, Lines),
    split_string(Line, ":", " \tkB", ["VmHWM", Text]),
    !,
    number_string(Kilobytes, Text).

times(Which) :-
    ( Which == smallest -> Most = 0 ; Most = 20 ),
    nb_setval(most_repeats, Most),
    steps(Which, offline, count, count),
    steps(Which, online, count, count),
    steps(Which, offline, count, frame),
    steps(Which, offline, toggle, toggle),
    steps(Which, offline, fluents, count),
    beside_many_fluents,
    forall(size(Which, [1, 10, 50], K), case(interrupts, none, interrupts(K, 100))),
    forall(size(Which, [10, 100, 500], Size), case(pick, Size, pick(50))),
    forall(size(Which, [2, 4, 8], K), case(conc, none, side_by_side(K, 50))),
    forall(size(Which, [4, 5, 6, 7], Size), case(blocks, Size, deepening)),
    forall(size(Which, [8, 12], Size), case(blocks, Size, astar)).

size(all, Sizes, Size) :-
    member(Size, Sizes).
size(smallest, [Size|_], Size).

%   steps(+Which, +Mode, +Theory, +Name): cost per step as the loop grows.

steps(Which, Mode, Theory, Name) :-
    theory(Theory, none),
    findall(N, size(Which, [1000, 5000, 20_000, 100_000], N), Ns),
    foldl(steps_of(Mode, Theory, Name), Ns, none, _).

steps_of(Mode, Theory, Name, N, First0, First) :-
    Program =.. [Name, N],
    seconds(Mode, Program, Seconds),
    PerStep is 1.0e6*Seconds/N,
    ( First0 == none -> First = PerStep ; First = First0 ),
    Ratio is PerStep/First,
    format(string(Label), "golog/~w/~w/~w(~d)", [Mode, Theory, Name, N]),
    show(Label, Seconds, "s", _{us_per_step:PerStep, of_first:Ratio}).

%   A step of the same loop with one fluent beside it, and with ten thousand that have all been set.

beside_many_fluents :-
    theory(fluents, none),
    once(do(mark_all, [], Marked)),
    seconds_from(Marked, while(counter < 20_000, inc), Many),
    theory(count, none),
    seconds(offline, count(10_000), Few),
    Ratio is Many/Few,
    show("golog/offline/10000 fluents set/10000 more steps", Many, "s", _{of_one_fluent:Ratio}).

case(Theory, Size, Program) :-
    theory(Theory, Size),
    seconds(offline, Program, Seconds),
    (   Size == none
    ->  format(string(Label), "golog/~w", [Program])
    ;   format(string(Label), "golog/~w/~d/~w", [Theory, Size, Program])
    ),
    show(Label, Seconds, "s", _{}).

theory(Name, Size) :-
    setenv('SIZE', Size),
    module_property(benchmark_golog, file(Here)),
    file_directory_name(Here, Folder),
    format(atom(File), '~w/theories/~w.pl', [Folder, Name]),
    load_theory(File).

%   seconds(+Mode, +Program, -Seconds): at least three runs, and no more than take a second.

seconds(Mode, Program, Seconds) :-
    least(executed(Mode, Program), Seconds).

seconds_from(History, Program, Seconds) :-
    least(continued(Program, History), Seconds).

least(Goal, Seconds) :-
    timed(Goal, _),
    timed(Goal, First),
    nb_getval(most_repeats, Most),
    Repeats is min(Most, max(2, truncate(1/max(First, 1.0e-3)))),
    findall(S, ( between(1, Repeats, _), timed(Goal, S) ), All),
    min_list([First|All], Seconds).

timed(Goal, Seconds) :-
    garbage_collect,
    statistics(process_cputime, Before),
    \+ \+ call(Goal),
    statistics(process_cputime, After),
    Seconds is max(1.0e-6, After-Before).

executed(offline, Program) :-
    once(do(Program, [], _)).
executed(online, Program) :-
    indigolog(Program, [device(benchmark_golog)]).

continued(Program, History) :-
    once(do(Program, History, _)).

%   The device of the online runs does everything at once and senses nothing.

:- public can_execute/1, execute/2.

can_execute(_).

execute(_, none).

show(Label, Value, Unit, More) :-
    put_dict(More, _{name:Label, value:Value, unit:Unit}, Dict),
    dict_pairs(Dict, Tag, Pairs0),
    findall(K-V, ( member(K-V0, Pairs0), rounded(V0, V) ), Pairs),
    dict_pairs(Rounded, Tag, Pairs),
    json_write_dict(current_output, Rounded, [width(0)]),
    nl,
    flush_output.

rounded(X, Y) :-
    (   float(X)
    ->  Digits is max(0, 3-floor(log10(max(abs(X), 1.0e-9)))),
        Y is round(X*10**Digits)/10.0**Digits
    ;   Y = X
    ).
