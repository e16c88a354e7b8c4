:- module(session_file,
          [ locked_session_file/2,      % +Folder, +New
            check_unlocked/1,           % +Folder
            write_session_file/1,       % +Options
            read_session_file/2,        % +Folder, -Options
            session_begun/1,            % +Folder
            file_sha256/2               % +File, -Sha256
          ]).
/** <module> session.pl in a run folder: what a session was asked to do, and the lock of who works in the folder

One option a line, between the version of the format and the SHA-256 of all lines before it, so that a file that was
cut or changed is known.  It is read as data: nothing in it is called.
*/

:- use_module('../usage_errors', [usage_error/2]).
:- autoload(library(apply), [maplist/2]).
:- use_module(library(lists), [append/3, member/2]).
:- autoload(library(sha), [hash_atom/2, sha_hash/3]).

format_version(1).

:- dynamic
    lock/1.                             % Stream: the lock is held as long as it is open

session_file(Folder, File) :-
    atomic_list_concat([Folder, '/session.pl'], File).

%!  locked_session_file(+Folder, +New) is det.
%
%   Hold the folder until this process ends; New is true where no session may have begun in it: what one left that was
%   killed before is cleared.  The system gives a lock back when its process ends, however that is, and when the process closes the file anywhere: so read first.
%
%   @error usage_error(Message) if another session works there

locked_session_file(Folder, New) :-
    session_file(Folder, File),
    open_locked(Folder, File, Stream),
    forall(retract(lock(Old)), close(Old)),
    assertz(lock(Stream)),
    (   New == true
    ->  (   session_begun(Folder)
        ->  usage_error("--out: another session has begun in ~w; name another folder", [Folder])
        ;   seek(Stream, 0, bof, _),
            set_end_of_stream(Stream)
        )
    ;   true
    ).

open_locked(Folder, File, Stream) :-
    catch(open(File, append, Stream, [encoding(utf8), lock(write), wait(false)]),
          error(permission_error(lock, _, _), _),
          usage_error("another session is running in ~w; wait for its end, or name another folder", [Folder])).

%!  check_unlocked(+Folder) is det.
%
%   For a process that does not hold the folder itself: it would give it back.
%
%   @error usage_error(Message) if a session works there

check_unlocked(Folder) :-
    session_file(Folder, File),
    (   exists_file(File)
    ->  open_locked(Folder, File, Stream),
        close(Stream)
    ;   true
    ).

%!  session_begun(+Folder) is semidet.
%
%   Its journal has a whole line.

session_begun(Folder) :-
    atomic_list_concat([Folder, '/history.pl'], Journal),
    exists_file(Journal),
    setup_call_cleanup(open(Journal, read, Stream, [encoding(utf8)]),
                       read_string(Stream, "\n", "", End, _),
                       close(Stream)),
    End == 0'\n.

%!  write_session_file(+Options) is det.
%
%   Into the file that is locked.

write_session_file(Options) :-
    format_version(Version),
    with_output_to(string(Text),
                   forall(member(Term, [version(Version)|Options]),
                          write_term(Term, [quoted(true), fullstop(true), nl(true)]))),
    sha_hash(Text, Hash, [algorithm(sha256), encoding(utf8)]),
    hash_atom(Hash, Sha256),
    lock(Stream),
    format(Stream, "~ssha256(~q).~n", [Text, Sha256]),
    flush_output(Stream).

%!  read_session_file(+Folder, -Options) is det.
%
%   @error usage_error(Message) if there is none, or it is not as it was written

read_session_file(Folder, Options) :-
    session_file(Folder, File),
    (   exists_file(File)
    ->  true
    ;   usage_error("~w holds no session that was begun (no session.pl and history.pl there)", [Folder])
    ),
    catch(read_terms(File, Text, Terms), error(_, _), Terms = []),
    (   append([version(Version)|Options0], [sha256(Sha256)], Terms),
        append(_, [_], Options0),
        maplist(is_option, Options0),
        sub_string(Text, Before, _, _, "\nsha256("),
        Length is Before + 1,
        sub_string(Text, 0, Length, _, Body),
        sha_hash(Body, Hash, [algorithm(sha256), encoding(utf8)]),
        hash_atom(Hash, Sha256)
    ->  true
    ;   usage_error("~w is empty, cut or changed: what the session was asked to do is not known any more",
                    [File])
    ),
    (   format_version(Version)
    ->  Options = Options0
    ;   usage_error("~w is of version ~w, which this version cannot read", [File, Version])
    ).

is_option(Term) :-
    compound(Term),
    Term =.. [_, Value],
    atomic(Value).

read_terms(File, Text, Terms) :-
    setup_call_cleanup(open(File, read, Stream, [encoding(utf8)]), read_string(Stream, _, Text), close(Stream)),
    setup_call_cleanup(open_string(Text, In), terms(In, Terms), close(In)).

terms(In, Terms) :-
    read_term(In, Term, []),
    (   Term == end_of_file
    ->  Terms = []
    ;   Terms = [Term|More],
        terms(In, More)
    ).

%!  file_sha256(+File, -Sha256) is det.

file_sha256(File, Sha256) :-
    setup_call_cleanup(open(File, read, Stream, [encoding(octet)]), read_string(Stream, _, Bytes), close(Stream)),
    sha_hash(Bytes, Hash, [algorithm(sha256), encoding(octet)]),
    hash_atom(Hash, Sha256).
