:- module(session_resumption,
          [ record_options/2,           % +Options, +Described
            resumed_options/3,          % +Given, +Folder, -Options
            again_options/3,            % +Given, +Folder, -Options
            journaled_action/2,         % +Folder, -Action
            begun_options/2,            % +Folder, -Options
            check_frames/1,             % +Folder
            missed_events/3             % +Actions, +Told, -Missed
          ]).
/** <module> Going on with a session that was interrupted

The run folder keeps the options that a session was begun with, so that `--resume DIR` needs nothing else. What was done is in its
journal (`history.pl`, written by indigolog/online/journal.pl): here it is checked, and the executive
(indigolog/online/executive.pl, turn.pl) follows it up to its end. What a vision server must know again is put together by
restoration.pl and sent by recovery.pl, which also brings back a server that died.
*/

:- use_module('../../indigolog/online/journal', [journal_entries/3]).
:- use_module(run_folder, [replace_file/2, run_file/3]).
:- use_module(session_file).
:- use_module('../shell_words', [shell_word/2]).
:- use_module('../strategy/strategy_file', [strategy_sha256/2]).
:- use_module('../usage_errors', [dashes/2, usage_error/2]).
:- use_module(library(apply), [exclude/3, maplist/3, partition/4]).
:- use_module(library(http/json), [json_read_dict/2]).
:- use_module(library(lists), [append/3, last/2, member/2, memberchk/2, select/3, selectchk/3]).
:- use_module(library(option), [merge_options/3, option/2]).
:- use_module(library(readutil), [read_file_to_string/3, read_file_to_terms/3]).

% What concerns how a session is shown or reached, and not what it does.
of_this_run(Option) :-
    functor(Option, Name, 1),
    memberchk(Name, [ json, quiet, explain, view, report, dry_run, out, resume, image_server, vision_server, keys,
                      keep_servers, idle_s ]).

% It may be reached elsewhere when the session goes on; where it is not said, it is where it was.
not_recorded(Option) :-
    of_this_run(Option),
    Option \= image_server(_).

%!  record_options(+Options, +Described) is det.
%
%   Keep in the run folder, which is locked, what the session was asked to do, with absolute paths, and on which device.

record_options(Options, Described) :-
    exclude(not_recorded, Options, Kept),
    maplist(with_absolute_path, Kept, Recorded),
    with_controller_hash([described(Described)|Recorded], Written),
    write_session_file(Written).

%   A controller of the user's is code: it is run again only as the file that it was.
with_controller_hash(Options, [controller_sha256(Sha256)|Options]) :-
    option(controller(File), Options),
    is_absolute_file_name(File),
    !,
    strategy_sha256(File, Sha256).
with_controller_hash(Options, Options).

with_absolute_path(Option, Absolute) :-
    Option =.. [Name, Path],
    memberchk(Name, [controller, target, scenario, stack, camera, lights, camera_model, seed_pose]),
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
    partition(of_this_run, Given, Here0, Others0),
    partition(=(controller(_)), Others0, Said, Others),
    (   Others = [Other|_]
    ->  functor(Other, Name, _),
        dashes(Name, Dashed),
        usage_error("--resume goes on with the session as it was begun: leave --~w out", [Dashed])
    ;   true
    ),
    (   session_begun(Folder)
    ->  true
    ;   usage_error("--resume: ~w holds no session that was begun; one that was interrupted before is begun anew by its command",
                    [Folder])
    ),
    read_session_file(Folder, Recorded1),
    same_source(Here0, Recorded1, Recorded0),
    run_file(Folder, 'history.pl', Journal),
    not_ended(Folder, Journal),
    same_controller(Said, Folder, Recorded0, Recorded),
    append(Here0, Recorded, Options).

% Images of another source are not of this session.
same_source(Here, Recorded0, Recorded) :-
    option(image_server(_), Here),
    !,
    (   select(image_server(_), Recorded0, Recorded)
    ->  true
    ;   usage_error("--resume: the images of this session are not from --image-server: leave it out", [])
    ).
same_source(_, Recorded, Recorded).

%!  begun_options(+Folder, -Options) is det.
%
%   The options that a session was begun with whose controller may be looked at by running it, as in resumed_options/3.

begun_options(Folder, Options) :-
    read_session_file(Folder, Recorded),
    same_controller([], Folder, Recorded, Options).

% One of the project's by name, or the file of then: where that came with the folder, the user has to name it.
same_controller(Said, Folder, Recorded0, Recorded) :-
    select(controller_sha256(Sha256), Recorded0, Recorded),
    !,
    option(controller(File), Recorded),
    as_it_was(File, Sha256, Folder),
    (   Said = [controller(Named)],
        exists_file(Named),
        same_file(Named, File)
    ->  true
    ;   Said == [],
        \+ inside(Folder, File)
    ->  true
    ;   usage_error("the session runs the controller ~w; if you trust it, add --controller ~w", [File, File])
    ).
same_controller(Said, _, Recorded, Recorded) :-
    option(controller(Name), Recorded),
    (   member(controller(Other), Said),
        Other \== Name
    ->  usage_error("--resume: the session was begun with the controller ~w: leave --controller out", [Name])
    ;   is_absolute_file_name(Name)
    ->  usage_error("session.pl names the controller ~w without its SHA-256", [Name])
    ;   true
    ).

as_it_was(File, Sha256, Folder) :-
    (   \+ exists_file(File)
    ->  usage_error("the controller ~w is not there any more: put back the file that the session was begun with", [File])
    ;   strategy_sha256(File, Sha256)
    ->  true
    ;   maplist(shell_word, [Folder, File], Words),
        usage_error("the controller ~w, or one that it includes, is not the file any more that the session was begun with: \c
                     put it back as it was, or do the session anew with it as it is now, --again ~w --controller ~w",
                    [File|Words])
    ).

inside(Folder, File) :-
    absolute_file_name(Folder, Absolute),
    atom_concat(Absolute, /, Prefix),
    sub_atom(File, 0, _, _, Prefix).

% Why a session with a result may not go on: it came to its end.  Without that result it goes on to write it.
not_ended(Folder, Journal) :-
    read_file_to_terms(Journal, Facts, [encoding(utf8), syntax_errors(quiet)]),
    append(_, [ended(Outcome)], Facts),
    \+ Outcome = error(_),
    run_file(Folder, 'result.json', File),
    catch(( open(File, read, Stream), call_cleanup(json_read_dict(Stream, Result), close(Stream)) ), error(_, _), fail),
    Result.get(status) \== "stopped",  % of an interruption before
    !,
    page_words(Folder, Page),
    usage_error("--resume: the session in ~w is finished; its outcome is in result.json there~w", [Folder, Page]).
not_ended(_, _).

%   One that was killed when it had told its outcome may have no page.
page_words(Folder, Words) :-
    run_file(Folder, 'report.html', File),
    (   exists_file(File)
    ->  Words = ''
    ;   shell_word(Folder, Word),
        format(atom(Words), ", and .venv/bin/python -m report ~w writes its page", [Word])
    ).

%!  again_options(+Given, +Folder, -Options) is det.
%
%   The options to do the session in Folder again, from its beginning: those that it was begun with, but for what is given
%   now, without its own what if, and on a device of its own.
%
%   @error usage_error(Message) for a session of another source of images, and as above

again_options(Given, Folder, Options) :-
    (   option(controller(_), Given)    % which is run then, whatever that of the session has become
    ->  read_session_file(Folder, Recorded1),
        exclude(of_its_controller, Recorded1, Recorded0)
    ;   begun_options(Folder, Recorded0)
    ),
    forall(( member(Option, Recorded0), functor(Option, Name, _), memberchk(Name, [camera, image_server]) ),
           ( dashes(Name, Dashed),
             usage_error("~w: the session used --~w, which cannot do the same again", [Folder, Dashed]) )),
    exclude(of_that_session, Recorded0, Recorded),
    selectchk(again(_), Given, Here),
    merge_options(Here, Recorded, Options).

of_its_controller(controller(_)).
of_its_controller(controller_sha256(_)).

of_that_session(instead(_)).
of_that_session(described(_)).

%!  journaled_action(+Folder, -Action) is nondet.
%
%   What the session in Folder has done, in order.

journaled_action(Folder, Action) :-
    run_file(Folder, 'history.pl', Journal),
    journal_entries(Journal, _, Entries),
    member(executed(_, Action, _), Entries).

%!  check_frames(+Folder) is det.
%
%   The frames of the session in Folder are those that were taken.  The last one, where it is not there, is to be taken
%   again: the journal then ends before it.  Frames that a vision server saved on another machine are left to it.
%
%   @error usage_error(Message) for another frame that is not as it was taken

check_frames(Folder) :-
    run_file(Folder, 'images/stack.toml', Stack),
    exists_file(Stack),
    run_file(Folder, 'history.pl', Journal),
    journal_entries(Journal, _, Entries),
    findall(Image, member(executed(_, capture(Image, _), _), Entries), Images),
    last(Images, Last),
    !,
    read_file_to_string(Stack, Text, [encoding(utf8)]),
    forall(( member(Image, Images), \+ ( Image == Last, \+ frame(Folder, Text, Last, _, _) ) ),
           check_frame(Folder, Text, Image)),
    (   frame(Folder, Text, Last, _, _)
    ->  true
    ;   end_journal_before(Journal, Last)
    ).
check_frames(_).

check_frame(Folder, Text, Image) :-
    (   frame(Folder, Text, Image, File, Sha256),
        file_sha256(File, Sha256)
    ->  true
    ;   usage_error("--resume: ~w/images/~w.png is not the frame that was taken; put it back", [Folder, Image])
    ).

%   A frame that is listed and there, and its SHA-256 as it was saved.
frame(Folder, Text, Image, File, Sha256) :-
    format(string(Named), "image = \"~w.png\"\nsha256 = \"", [Image]),
    sub_string(Text, At, Length, _, Named),
    !,
    Begin is At + Length,
    sub_atom(Text, Begin, 64, _, Sha256),
    format(atom(File), "~w/images/~w.png", [Folder, Image]),
    exists_file(File).

end_journal_before(Journal, Image) :-
    read_file_to_string(Journal, Text, [encoding(utf8)]),
    format(string(Begin), "capture(~q,", [Image]),
    once(sub_string(Text, At, _, _, Begin)),
    sub_string(Text, 0, At, _, Head),
    split_string(Head, "\n", "", Lines0),
    append(Lines, [_], Lines0),
    atomic_list_concat(Lines, '\n', Kept),
    replace_file(Journal, write_line(Kept)).

write_line(Text, Stream) :-
    format(Stream, "~w~n", [Text]).

%!  missed_events(+Actions, +Told, -Missed) is det.
%
%   Of the events that an image server told with the last thing that it did: those that the journal, newest action
%   first, does not have.

missed_events([Action|Newer], Told0, Missed) :-
    (   memberchk(Action, [sun_changed, target_moved])
    ->  ( told_of(Action, Told0, Told) -> true ; Told = Told0 ),
        missed_events(Newer, Told, Missed)
    ;   memberchk(Action, [light_fault(_), camera_fault, surprise(_, _), doubt(_, _)])
    ->  missed_events(Newer, Told0, Missed)
    ;   Action = advance(_)
    ->  ( told_of(target_moved, Told0, Missed) -> true ; Missed = Told0 )
    ;   memberchk(Action, [capture(_, _), e(capture(_, _), _)])
    ->  Missed = Told0
    ;   Missed = []
    ).

told_of(Name, Told, Rest) :-
    atom_string(Name, String),
    member(Event, Told),
    Event.event == String,
    !,
    selectchk(Event, Told, Rest).
