:- module(session_resumption,
          [ record_options/2,           % +Options, +Folder
            resumed_options/3,          % +Given, +Folder, -Options
            captures_taken/2            % +Folder, -Count
          ]).
:- use_module('../indigolog/online/journal', [journal_entries/3]).
:- use_module(run_folder, [run_file/3]).
:- use_module(usage, [dashes/2, usage_error/2]).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(apply), [exclude/3, maplist/3, partition/4]).
:- use_module(library(lists), [append/3, member/2]).
:- use_module(library(readutil), [read_file_to_terms/3]).

/** <module> Going on with a session that was interrupted

The run folder keeps the options that a session was begun with, so that `--resume
DIR` needs nothing else: the journal is replayed, the vision server gets its
images back from the folder, and the session goes on where it stopped.
*/

options_file('session.pl').

% What concerns how a session is shown or reached, and not what it does.
of_this_run(json(_)).
of_this_run(quiet(_)).
of_this_run(explain(_)).
of_this_run(report(_)).
of_this_run(dry_run(_)).
of_this_run(out(_)).
of_this_run(resume(_)).
of_this_run(image_server(_)).
of_this_run(vision_server(_)).
of_this_run(keys(_)).
of_this_run(keep_servers(_)).
of_this_run(idle_s(_)).

% Options whose value may be a path.
path_option(controller).
path_option(target).
path_option(scenario).
path_option(stack).
path_option(camera_model).
path_option(seed_pose).

%!  record_options(+Options, +Folder) is det.
%
%   Keep in Folder what the session was asked to do, with absolute paths.

record_options(Options, Folder) :-
    exclude(of_this_run, Options, Kept),
    maplist(with_absolute_path, Kept, Recorded),
    options_file(Name),
    run_file(Folder, Name, File),
    setup_call_cleanup(
        open(File, write, Stream, [encoding(utf8)]),
        forall(member(Option, Recorded),
               write_term(Stream, Option, [quoted(true), fullstop(true), nl(true)])),
        close(Stream)).

with_absolute_path(Option, Absolute) :-
    Option =.. [Name, Path],
    path_option(Name),
    ( Name == stack -> exists_directory(Path) ; exists_file(Path) ),
    !,
    absolute_file_name(Path, File),
    Absolute =.. [Name, File].
with_absolute_path(Option, Option).

%!  resumed_options(+Given, +Folder, -Options) is det.
%
%   The options that the session in Folder was begun with, and of those given now
%   the ones that concern only this run.
%
%   @error usage_error(Message) for another option, or a folder without such a session

resumed_options(Given, Folder, Options) :-
    partition(of_this_run, Given, Here, Others),
    (   Others = [Other|_]
    ->  functor(Other, Name, _),
        dashes(Name, Dashed),
        usage_error("--resume goes on with the session as it was begun: leave --~w away", [Dashed])
    ;   true
    ),
    options_file(Name1),
    run_file(Folder, Name1, File),
    run_file(Folder, 'history.pl', Journal),
    (   exists_file(File),
        exists_file(Journal)
    ->  true
    ;   usage_error("--resume: ~w holds no session that was begun (no session.pl and history.pl there)",
                    [Folder])
    ),
    not_ended(Folder, Journal),
    read_file_to_terms(File, Recorded, [encoding(utf8)]),
    append(Here, Recorded, Options).

% Why a session with a result may not go on: it came to its end.
not_ended(Folder, Journal) :-
    read_file_to_terms(Journal, Facts, [encoding(utf8), syntax_errors(quiet)]),
    append(_, [ended(Outcome)], Facts),
    \+ Outcome = error(_),
    !,
    usage_error("--resume: the session in ~w is finished; its outcome is in result.json there", [Folder]).
not_ended(_, _).

%!  captures_taken(+Folder, -Count) is det.
%
%   How many images the session in Folder has taken.

captures_taken(Folder, Count) :-
    run_file(Folder, 'history.pl', Journal),
    journal_entries(Journal, _, Entries),
    !,
    aggregate_all(count, member(executed(_, capture(_, _), _), Entries), Count).
captures_taken(_, 0).
