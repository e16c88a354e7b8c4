:- module(indigolog_journal,
          [ journal_open/2,           % +File, -Journal
            journal_write/2,          % +Journal, +Fact
            journal_close/1,          % +Journal
            journal_entries/3         % +File, -Begun, -Entries
          ]).
:- use_module(library(apply), [partition/4, include/3]).
:- use_module(library(readutil), [read_file_to_terms/3]).

/** <module> The journal of a run

One Prolog fact an event, flushed before the next step:

    begun(Program, Seed).             % the program and the seed of its choices
    executed(Turn, Action, Sensing).  % Sensing is `none` if nothing was sensed
    exogenous(Turn, Action).
    failed(Turn, Action, Reason).     % a device could not do Action
    ended(Outcome).

Turn counts the steps of the program, those without an action too, so that a
resumed run meets each exogenous action where it was met.
*/

%!  journal_open(+File, -Journal) is det.
%
%   Append to File; File may be `none`.

journal_open(none, Journal) =>
    Journal = none.
journal_open(File, Journal) =>
    open(File, append, Journal, [encoding(utf8)]).

%!  journal_write(+Journal, +Fact) is det.

journal_write(none, _) =>
    true.
journal_write(Journal, Fact) =>
    write_term(Journal, Fact,
               [ quoted(true), ignore_ops(false), numbervars(false),
                 fullstop(true), nl(true) ]),
    flush_output(Journal).

journal_close(none) =>
    true.
journal_close(Journal) =>
    close(Journal).

%!  journal_entries(+File, -Begun, -Entries) is semidet.
%
%   What was begun, and what happened, in order.  Fails if File tells of no run.

journal_entries(File, Begun, Entries) :-
    read_file_to_terms(File, Facts, [encoding(utf8)]),
    partition(is_begun, Facts, [Begun|_], Events),
    include(is_event, Events, Entries).

is_begun(begun(_, _)).

is_event(executed(_, _, _)).
is_event(exogenous(_, _)).
is_event(failed(_, _, _)).
