:- module(indigolog_journal,
          [ journal_open/3,           % +File, +Told, -Journal
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
    ended(Outcome).                   % of an error what is not too deep

Turn counts the steps of the program, those without an action too, so that a
resumed run meets each exogenous action where it was met.

A journal that is written is journal(Stream, File, Told): Told counts the facts still to come
that File tells of already, and that are not written again.
*/

:- use_module(library(apply), [partition/4, include/3]).

:- dynamic in_use/2.                    % Stream, File

%!  journal_open(+File, +Told, -Journal) is det.
%
%   Write to File; File may be `none`.  Its first Told facts are there already, from the
%   run that is resumed.  A last line that was not finished, as a process leaves it that is
%   killed while it writes, is dropped.
%
%   @error golog(journal_in_use(File)) if another run of this process writes to it,
%          golog(journal_exists(File)) if Told is 0 and File tells of a run, or of something else

journal_open(none, _, Journal) =>
    Journal = none.
journal_open(File, Told, Journal) =>
    with_mutex(indigolog_journal,
               ( ( exists_file(File) -> not_in_use(File), may_be_written(File, Told) ; true ),
                 open(File, append, Stream, [encoding(utf8)]),
                 assertz(in_use(Stream, File)) )),
    Journal = journal(Stream, File, Told).

% A second run in one file could not be told from the first.
may_be_written(File, Told) :-
    (   size_file(File, 0)
    ->  true
    ;   ( Told > 0 ; not_yet_begun(File) )
    ->  drop_unfinished(File)
    ;   throw(error(golog(journal_exists(File)), _))
    ).

% Its only line was not finished.
not_yet_begun(File) :-
    whole_lines(File, 0),
    setup_call_cleanup(open(File, read, Stream, [encoding(utf8)]),
                       read_string(Stream, 6, Start),
                       close(Stream)),
    string_concat(Start, _, "begun(").

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
%
%   @error golog(journal_not_written(File, Why))

journal_write(none, _) =>
    true.
journal_write(Journal, _), Journal = journal(_, _, Told), Told > 0 =>
    Told1 is Told-1,
    nb_setarg(3, Journal, Told1).
journal_write(journal(Stream, File, _), Fact) =>
    most_depth(Fact, Depth),
    catch(( write_term(Stream, Fact,
                       [ quoted(true), ignore_ops(false), numbervars(false), max_depth(Depth),
                         fullstop(true), nl(true) ]),
            flush_output(Stream) ),
          error(io_error(write, _), context(_, Why)),
          throw(error(golog(journal_not_written(File, Why)), _))).

% An error may hold a term that is too deep to be written: Prolog leaves such a line unfinished.
most_depth(ended(_), Depth) => Depth = 100.
most_depth(_, Depth) => Depth = 0.      % all of it

% What a full disk did not take would be tried again, and that error hide the first.
journal_close(none) =>
    true.
journal_close(journal(Stream, _, _)) =>
    retractall(in_use(Stream, _)),
    close(Stream, [force(true)]).

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
