:- module(session_kept_servers,
          [ kept_server/4,              % +Name, +Arguments, -Base, -Found
            keep_server/2,              % +Base, +Process
            kept_running/2,             % +Base, -Pid
            kept_log/2                  % +Base, -LogFile
          ]).
/** <module> Servers that stay when the session that started them ends

Each has a name in a folder of the user's own, `Base`, that says what it is: which installation of which age, and
with which arguments it was started.  So one that is found fits.

| Base         | its socket                                                  |
| Base`.lock`  | locked by the session that uses it; a second one takes a server of its own |
| Base`.pid`   | its process                                                 |
| Base`.log`   | its output                                                  |
*/

:- use_module('../installation', [installation_python/1, installation_root/1]).
:- use_module(serving_processes, [serving_process/2]).
:- autoload(library(filesex), [chmod/2, make_directory_path/1]).
:- use_module(library(lists), [max_list/2, member/2]).
:- autoload(library(readutil), [read_file_to_terms/3]).
:- autoload(library(uid), [getuid/1]).

most_servers(16).                       % of one kind at a time, chosen by hand

%!  kept_server(+Name, +Arguments, -Base, -Found) is det.
%
%   Base of a server that no other session uses, locked until this process ends.  Found is kept(Name, Pid, Base) for
%   one that runs, or `none`: then it is to be started there.
%
%   @error permission_error(lock, server, Name) where all are in use

kept_server(Name, Arguments, Base, Found) :-
    runtime_folder(Folder),
    installation_python(Python),
    installation_root(Root),
    newest_source(Root, Time),
    findall(File-Changed, ( member(Word, Arguments), input_file(Word, File), time_file(File, Changed) ), Inputs),
    variant_sha1(server(Python, Root, Time, Arguments, Inputs), Digest),
    sub_atom(Digest, 0, 12, _, Key),
    most_servers(Most),
    (   between(1, Most, Number),
        format(atom(Base), "~w/~w-~w-~d", [Folder, Name, Key, Number]),
        locked(Base)
    ->  true
    ;   throw(error(permission_error(lock, server, Name), _))
    ),
    (   running(Base, Pid)
    ->  Found = kept(Name, Pid, Base)
    ;   Found = none
    ).

%   A session that was killed may not have come to say which process it started.
running(Base, Pid) :-
    kept_running(Base, Pid),
    !.
running(Base, Pid) :-
    serves(Pid, Base),
    !,
    note_pid(Base, Pid).

%   A folder that is another user's cannot be given these rights: then this throws.
runtime_folder(Folder) :-
    (   getenv('XDG_RUNTIME_DIR', Parent), exists_directory(Parent)
    ->  atom_concat(Parent, '/lights-and-camera', Folder)
    ;   ( getenv('TMPDIR', Parent) -> true ; Parent = '/tmp' ),
        getuid(User),
        format(atom(Folder), "~w/lights-and-camera-~w", [Parent, User])
    ),
    make_directory_path(Folder),
    chmod(Folder, 0o700).

%   When the servers' code was last changed: those that run older code do not fit.
newest_source(Root, Time) :-
    findall(Modified,
            ( member(Room, [bridge, geometry, numerics, stack, image_server, vision_server]),
              member(Depth, ['/*.py', '/*/*.py']),
              atomic_list_concat([Root, /, Room, Depth], Pattern),
              expand_file_name(Pattern, Files),
              member(File, Files),
              time_file(File, Modified) ),
            Times),
    max_list(Times, Time).

%   A file that a server reads at its start, where an argument names one.
input_file(Word, File) :-
    member(Suffix, ['', '/stack.toml']),
    atom_concat(Word, Suffix, File),
    exists_file(File).

locked(Base) :-
    atom_concat(Base, '.lock', File),
    catch(open(File, update, _, [lock(write), wait(false), close_on_exec(true), alias(Base)]),
          error(permission_error(_, _, _), _),
          fail).

%!  kept_running(+Base, -Pid) is semidet.
%
%   The process that listens there; of the one that the file names, it is looked whether it is that.

kept_running(Base, Pid) :-
    atom_concat(Base, '.pid', File),
    catch(read_file_to_terms(File, [Pid], []), error(_, _), fail),
    serves(Pid, Base),
    !.

serves(Pid, Base) :-
    atom_concat('ipc://', Base, Endpoint),
    serving_process(Endpoint, Pid).

%!  keep_server(+Base, +Process) is det.
%
%   Say that the process serves there.

keep_server(Base, process(_, Pid, _)) :-
    note_pid(Base, Pid).

note_pid(Base, Pid) :-
    atom_concat(Base, '.pid', File),
    setup_call_cleanup(open(File, write, Stream),
                       format(Stream, "~w.~n", [Pid]),
                       close(Stream)).

%!  kept_log(+Base, -LogFile) is det.

kept_log(Base, LogFile) :-
    atom_concat(Base, '.log', LogFile).
