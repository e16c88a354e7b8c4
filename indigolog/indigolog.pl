:- module(indigolog,
          [ load_theory/1,            % +FileOrFiles
            load_theory/2,            % +FileOrFiles, -Theory
            in_theory/2,              % +Theory, :Goal
            unload_theory/1,          % +Theory
            do/3,                     % +Program, +History, -History1
            do/4,                     % +Program, +History, +Max, -History1
            trans/4,                  % +Program, +History, -Program1, -History1
            final/2,                  % +Program, +History
            holds/2,                  % +Formula, +History
            indigolog/1,              % +Program
            indigolog/2,              % +Program, :Options
            request_stop/1,           % +Reason
            request_stop/2,           % +Run, +Reason
            request_abort/0,
            request_abort/1,          % +Run
            report_exogenous/1,       % +Action
            report_exogenous/2,       % +Run, +Action
            current_run/1,            % -Run
            check_theory/0,
            check_program/1,          % +Program
            explain/2,                % +Question, +History
            step_through/2,           % +Program, +Options
            fluent_value/3,           % ?Fluent, +Situation, -Value
            situation_holds/2,        % +Formula, +Situation
            situation_history/2       % +Situation, -History
          ]).
/** <module> IndiGolog

Histories here are lists, newest action first.
*/

:- use_module(library(error), [must_be/2]).
:- use_module(library(option), [option/2, option/3]).
:- use_module(language/context, [top_context/1]).
:- use_module(language/formula, [test/2]).
:- use_module(language/loading, [load_theory/1, load_theory/2, unload_theory/1]).
:- use_module(language/theory, [in_theory/2]).
:- use_module(language/offline, [complete/3, complete/4]).
:- use_module(language/history, [history_situation/2, remember_situation/1]).
:- use_module(language/semantics, [step/4]).
:- use_module(language/situation, [fluent_value/3, situation_history/2, situation_length/2]).
:- use_module(language/golog, []).
:- use_module(language/congolog, []).
:- use_module(language/conditions, []).
:- use_module(language/extensions, []).
:- use_module(search/search, []).
:- use_module(search/conditional, []).
:- use_module(search/monitor, []).
:- use_module(online/executive, [run/2]).
:- use_module(online/runs,
              [ current_run/1, report_exogenous/1, report_exogenous/2, request_abort/0, request_abort/1,
                request_stop/1, request_stop/2 ]).
:- use_module(tools/checks, [check_program/1, check_theory/0, check_theory_once/0]).
:- use_module(tools/console, [step_through/2]).
:- use_module(tools/explain, [why/3]).
:- use_module(tools/messages, []).
:- use_module(tools/point, []).

:- meta_predicate indigolog(+, :).

%!  do(+Program, +History, -History1) is nondet.
%
%   History1 is the history after a complete execution of Program from History.

do(Program, History, History1) :-
    history_situation(History, S),
    complete(Program, S, S1),
    situation_history(S1, History1),
    remember_situation(S1).

%!  do(+Program, +History, +Max, -History1) is nondet.
%
%   As do/3, for executions that add at most Max entries to History: there may be no end
%   to longer ones.

do(Program, History, Max, History1) :-
    must_be(nonneg, Max),
    history_situation(History, S),
    situation_length(S, N),
    Longest is N+Max,
    complete(Program, S, Longest, S1),
    situation_history(S1, History1),
    remember_situation(S1).

%!  trans(+Program, +History, -Program1, -History1) is nondet.

trans(Program, History, Program1, History1) :-
    history_situation(History, S),
    step(Program, S, Program1, S1),
    situation_history(S1, History1),
    remember_situation(S1).

%!  final(+Program, +History) is semidet.

final(Program, History) :-
    history_situation(History, S),
    top_context(C),
    indigolog_semantics:final(Program, S, C),
    !.

%!  holds(+Formula, +History) is nondet.

holds(Formula, History) :-
    history_situation(History, S),
    test(Formula, S).

%!  explain(+Question, +History) is det.
%
%   Print why, after History, something is not so.  Question is poss(Action): why is
%   Action not possible? holds(Formula): why is Formula false? search(Program): which
%   ways did the search for a complete execution reject? Or a program: why has it no
%   step?

explain(Question, History) :-
    history_situation(History, S),
    why(Question, S, Whys),
    print_message(help, golog(why(Whys))).

%!  situation_holds(+Formula, +Situation) is nondet.
%
%   Formula is true in a situation handed out by indigolog/2.

situation_holds(Formula, Situation) :-
    test(Formula, Situation).

%!  indigolog(+Program) is det.
%!  indigolog(+Program, :Options) is det.
%
%   Run Program online. Options:
%
%     * theory(Theory)       of load_theory/2; the current theory if it is not given
%     * run(Name)            for report_exogenous/2, request_stop/2, request_abort/1 and
%       current_run/1
%     * check(Boolean)       look for mistakes in the theory, if that has not been done
%       since it was loaded, and in Program, and print them; true by default
%     * device(Module), device(Module, DeviceOptions)   see devices.pl; may be
%       given more than once.  Without one the theory's execute/2 and exog_occurs/1
%       are asked, or the terminal
%     * deadline(Seconds)    for each action of a device
%     * journal(File)        write a fact for each event; File is new or empty, or the one that is resumed
%     * resume(File)         replay that journal first
%     * replay(File)         replay that journal and nothing more: no device is called
%     * follow(:Closure)     with replay(File): called with the program that is left and the
%       situation when the journal has been replayed; where it succeeds, what was added to
%       the journal meanwhile is replayed, too, and it is called again
%     * seed(Integer)        of random choices
%     * max_actions(N)       stop with outcome `limit`
%     * max_silent(N)        an error after N steps without an action
%     * max_wait(Seconds)    the longest wait for an exogenous action
%     * on_action(:Closure)  called with each action, exogenous ones too, and the
%       situation after it
%     * on_fact(:Closure)    called with each fact of the journal and the situation
%       after it
%     * history(-History), situation(-Situation), rest(-Program)   where it ended
%     * outcome(-Outcome)    `final`, `failed`, `limit`, `aborted` or `replayed`;
%       without this option anything but the first and the last is an error
%
%   @error golog(reported) if the theory or Program has mistakes; golog(_), and whatever
%          a device throws; stopped(Reason) after request_stop/1

indigolog(Program) :-
    indigolog(Program, []).

indigolog(Program, Options) :-
    Options = _:Plain,
    must_be(list, Plain),
    (   option(theory(Theory), Plain)
    ->  in_theory(Theory, checked_run(Program, Options))
    ;   checked_run(Program, Options)
    ).

checked_run(Program, Options) :-
    Options = _:Plain,
    (   option(check(true), Plain, true)
    ->  check_theory_once,
        check_program(Program)
    ;   true
    ),
    run(Program, Options).
