:- module(indigolog_journal,
          [ journal_open/2,           % +File, -Journal
            journal_write/2,          % +Journal, +Fact
            journal_close/1,          % +Journal
            journal_entries/3,        % +File, -Begun, -Entries
            journal_entries/4,        % +File, -Begun, -Entries, -Bytes
            journal_added/4           % +File, +Byte0, -Byte, -Entries
          ]).
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

:- use_module(library(apply), [partition/4, include/3]).

:- dynamic in_use/2.                    % Journal, File

%!  journal_open(+File, -Journal) is det.
%
%   Append to File; File may be `none`.  A last line that was not finished, as a
%   process leaves it that is killed while it writes, is dropped.
%
%   @error golog(journal_in_use(File)) if another run of this process writes to it

journal_open(none, Journal) =>
    Journal = none.
journal_open(File, Journal) =>
    with_mutex(indigolog_journal,
               ( ( exists_file(File) -> not_in_use(File), drop_unfinished(File) ; true ),
                 open(File, append, Journal, [encoding(utf8)]),
                 assertz(in_use(Journal, File)) )).

%   Kept here, since looking through all streams fails where another thread closes one meanwhile.
not_in_use(File) :-
    (   in_use(_, Other),
        same_file(File, Other)
    ->  throw(error(golog(journal_in_use(File)), _))
    ;   true
    ).

drop_unfinished(File) :-
    whole_lines(File, Bytes),
    size_file(File, Size),
    (   Bytes < Size
    ->  setup_call_cleanup(open(File, update, Stream, [type(binary)]),
                           ( seek(Stream, Bytes, bof, _),
                             set_end_of_stream(Stream) ),
                           close(Stream))
    ;   true
    ).

% The bytes up to the end of the last line that is finished.
whole_lines(File, Bytes) :-
    whole_lines(File, 0, Bytes).

% The same, where the first Bytes0 are known to end with a line.
whole_lines(File, Bytes0, Bytes) :-
    setup_call_cleanup(open(File, read, Stream, [type(binary)]),
                       ( seek(Stream, Bytes0, bof, _),
                         last_line_end(Stream, Bytes0, Bytes) ),
                       close(Stream)).

last_line_end(Stream, Bytes0, Bytes) :-
    get_byte(Stream, Byte),
    (   Byte == -1
    ->  Bytes = Bytes0
    ;   Byte == 0'\n
    ->  byte_count(Stream, Bytes1),
        last_line_end(Stream, Bytes1, Bytes)
    ;   last_line_end(Stream, Bytes0, Bytes)
    ).

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
    retractall(in_use(Journal, _)),
    close(Journal).

%!  journal_entries(+File, -Begun, -Entries) is semidet.
%!  journal_entries(+File, -Begun, -Entries, -Bytes) is semidet.
%
%   What was begun, and what happened, in order, in the first Bytes of File: those of whole lines.  Fails if File
%   tells of no run.
%
%   @error golog(journal(File, Line)) if a line, except an unfinished last one, is
%          not a fact

journal_entries(File, Begun, Entries) :-
    journal_entries(File, Begun, Entries, _).

journal_entries(File, Begun, Entries, Bytes) :-
    whole_lines(File, Bytes),
    setup_call_cleanup(open(File, read, Stream, [encoding(utf8)]),
                       facts(Stream, File, Bytes, Facts),
                       close(Stream)),
    partition(is_begun, Facts, [Begun|_], Events),
    include(is_event, Events, Entries).

%!  journal_added(+File, +Byte0, -Byte, -Entries) is det.
%
%   What has happened after the first Byte0 bytes of File, up to Byte, the end of its last line that is finished.
%
%   @error golog(journal(File, Line)) as of journal_entries/3; lines are counted from Byte0

journal_added(File, Byte0, Byte, Entries) :-
    whole_lines(File, Byte0, Byte),
    setup_call_cleanup(open(File, read, Stream, [encoding(utf8)]),
                       ( seek(Stream, Byte0, bof, _),
                         facts(Stream, File, Byte, Facts) ),
                       close(Stream)),
    include(is_event, Facts, Entries).

facts(Stream, File, Bytes, Facts) :-
    byte_count(Stream, Here),
    (   Here >= Bytes
    ->  Facts = []
    ;   line_count(Stream, Line),
        catch(read_term(Stream, Fact, []),
              error(syntax_error(_), _),
              throw(error(golog(journal(File, Line)), _))),
        (   Fact == end_of_file
        ->  Facts = []
        ;   Facts = [Fact|More],
            skip(Stream, 0'\n),
            facts(Stream, File, Bytes, More)
        )
    ).

is_begun(begun(_, _)).

is_event(executed(_, _, _)).
is_event(exogenous(_, _)).
is_event(failed(_, _, _)).
