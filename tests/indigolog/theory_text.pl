:- module(theory_text,
          [ load_text/1,              % +Text
            load_text/2               % +Text, -Theory
          ]).
/** <module> Theories that tests give as text */

:- use_module('../../indigolog/indigolog', [load_theory/1, load_theory/2]).

:- meta_predicate in_file(+, 1).

%!  load_text(+Text) is det.
%!  load_text(+Text, -Theory) is det.

load_text(Text) :-
    in_file(Text, load_theory).

load_text(Text, Theory) :-
    in_file(Text, loaded(Theory)).

loaded(Theory, File) :-
    load_theory(File, Theory).

in_file(Text, Goal) :-
    setup_call_cleanup(
        tmp_file_stream(File, Stream, [encoding(utf8), extension(pl)]),
        ( format(Stream, "~s", [Text]),
          close(Stream),
          call(Goal, File) ),
        delete_file(File)).
