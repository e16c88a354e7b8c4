:- module(session_run_folder,
          [ make_run_folder/3,          % +Options, +Plan, -Folder
            check_run_folder/2,         % +Options, +Plan
            leave_run_folder/3,         % +Options, +Folder, +Error
            replace_file/2,             % +File, :Write
            run_file/3                  % +Folder, +Name, -File
          ]).
/** <module> The folder that a session leaves behind */

:- use_module(session_file, [check_unlocked/1, locked_session_file/2, session_begun/1]).
:- use_module('../usage_errors', [refused_by_server/1, usage_error/2]).
:- autoload(library(filesex), [delete_directory_and_contents/1]).
:- use_module(library(lists), [member/2, memberchk/2, subtract/3]).
:- use_module(library(option), [option/2]).

:- meta_predicate replace_file(+, 1).

%!  make_run_folder(+Options, +Plan, -Folder) is det.
%
%   The folder of `--resume`, of `--out`, or a new one in `runs/` of the working directory; an absolute path.
%
%   @error usage_error(Message) if it cannot be made or written to

make_run_folder(Options, _, Folder) :-
    option(resume(Given), Options),
    !,
    absolute_file_name(Given, Folder),
    writable(Folder, "--resume"),
    locked_session_file(Folder, false).
make_run_folder(Options, Plan, Folder) :-
    made_folder(Options, Plan, Folder),
    writable(Folder, "--out"),
    unused_folder(Folder),
    locked_session_file(Folder, true).

%   One without a name is new: of sessions that begin at once each has its own.
made_folder(Options, Plan, Folder) :-
    folder_name(Options, Plan, Given),
    absolute_file_name(Given, Folder0),
    (   option(out(_), Options)
    ->  catch(make_folder(Folder0), error(_, _), cannot("--out", "make", Folder0)),
        Folder = Folder0
    ;   file_directory_name(Folder0, Runs),
        catch(( make_folder(Runs), make_directory(Folder0) ), error(_, _), fail)
    ->  Folder = Folder0
    ;   exists_directory(Folder0)
    ->  made_folder(Options, Plan, Folder)
    ;   cannot("--out", "make", Folder0)
    ).

%!  check_run_folder(+Options, +Plan) is det.
%
%   Whether make_run_folder/3 could make it; what is made to see that is removed again.
%
%   @error usage_error(Message) as there

check_run_folder(Options, _) :-
    option(resume(Given), Options),
    !,
    absolute_file_name(Given, Folder),
    writable(Folder, "--resume").
check_run_folder(Options, Plan) :-
    folder_name(Options, Plan, Given),
    absolute_file_name(Given, Folder),
    missing_folders(Folder, Missing),
    call_cleanup(( catch(make_folder(Folder), error(_, _), cannot("--out", "make", Folder)),
                   writable(Folder, "--out"),
                   unused_folder(Folder) ),
                 forall(member(Made, Missing), catch(delete_directory(Made), error(_, _), true))).

%   The innermost first.
missing_folders(Folder, []) :-
    exists_directory(Folder),
    !.
missing_folders(Folder, [Folder|Missing]) :-
    file_directory_name(Folder, Above),
    ( Above == Folder -> Missing = [] ; missing_folders(Above, Missing) ).

%   Nothing of another session, or of anything else, is mixed with this one.
unused_folder(Folder) :-
    check_unlocked(Folder),
    run_file(Folder, 'result.json', Result),
    exists_file(Result),
    !,
    usage_error("--out: ~w holds a finished session already; name another folder, or remove it", [Folder]).
unused_folder(Folder) :-
    session_begun(Folder),
    !,
    usage_error("--out: ~w holds an interrupted session; go on with it by --resume, or name another folder", [Folder]).
unused_folder(Folder) :-
    directory_files(Folder, Files),
    logs(Logs),                         % of a session that came to nothing
    probe(Probe),
    subtract(Files, ['.', '..', Probe, 'session.pl', 'history.pl'|Logs], Others), % who has that one is asked by its lock
    (   Others = [Other|_]
    ->  usage_error("--out: ~w is in use for something else (it holds ~w); name a new folder", [Folder, Other])
    ;   true
    ).

probe('.write-test').

%   As make_directory_path/1 does; its library takes longer to load than all of this.
make_folder(Folder) :-
    exists_directory(Folder),
    !.
make_folder(Folder) :-
    file_directory_name(Folder, Above),
    make_folder(Above),
    catch(make_directory(Folder), Error, ( exists_directory(Folder) -> true ; throw(Error) )). % another made it

writable(Folder, Option) :-
    probe(Name),
    run_file(Folder, Name, Probe),
    catch(( open(Probe, write, Stream), close(Stream), delete_file(Probe) ),
          error(_, _), cannot(Option, "write to", Folder)).

folder_name(Options, _, Folder) :-
    option(out(Folder), Options),
    !.
folder_name(_, Plan, Folder) :-
    get_time(Now),
    format_time(atom(Time), '%Y-%m-%dT%H-%M-%S', Now),
    unused(Time, Plan, 1, Folder).

unused(Time, Plan, N, Folder) :-
    ( N =:= 1 -> Suffix = '' ; format(atom(Suffix), "-~d", [N]) ),
    format(atom(Name), "runs/~w-~w-~w~w", [Time, Plan.controller, Plan.target, Suffix]),
    (   exists_directory(Name)
    ->  N1 is N + 1,
        unused(Time, Plan, N1, Folder)
    ;   Folder = Name
    ).

cannot(Option, What, Folder) :-
    usage_error("~s: cannot ~s ~w; choose a folder you may write to", [Option, What, Folder]).

%!  leave_run_folder(+Options, +Folder, +Error) is det.
%
%   Take back make_run_folder/3 where no image came of it, for this error or `none`; a folder that was to be resumed stays
%   as it is.

leave_run_folder(Options, _, _) :-
    option(resume(_), Options),
    !.
leave_run_folder(_, Folder, Error) :-
    logs(Logs),
    forall(( member(Name, ['session.pl', 'history.pl'|Logs]), run_file(Folder, Name, File), not_told(Error, Name, File) ),
           catch(delete_file(File), error(_, _), true)),
    run_file(Folder, images, Images),
    atom_concat(Images, '/*.png', Frames),
    ( expand_file_name(Frames, []) -> catch(delete_directory_and_contents(Images), error(_, _), true) ; true ),
    catch(delete_directory(Folder), error(_, _), true).     % where nothing else is in it

logs(['vision_server.log', 'image_server.log']).

%   A log that says something has been named to the user, but one that says no more than the error.
not_told(error(Formal, _), _, _) :-
    refused_by_server(Formal),
    !.
not_told(_, Name, _) :-
    memberchk(Name, ['session.pl', 'history.pl']),
    !.
not_told(_, _, File) :-
    exists_file(File),
    size_file(File, 0).

%!  replace_file(+File, :Write) is det.
%
%   What call(Write, Stream) writes is File's text from now on: written beside its place and then moved there, so that
%   a reader never sees half.

replace_file(File, Write) :-
    atom_concat(File, '.new', New),
    setup_call_cleanup(open(New, write, Stream, [encoding(utf8)]), call(Write, Stream), close(Stream)),
    rename_file(New, File).

%!  run_file(+Folder, +Name, -File) is det.

run_file(Folder, Name, File) :-
    atomic_list_concat([Folder, /, Name], File).
