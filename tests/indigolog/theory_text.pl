:- module(theory_text,
          [ load_text/1               % +Text
          ]).
:- use_module('../../indigolog/indigolog', [load_theory/1]).

/** <module> Theories that tests give as text */

%!  load_text(+Text) is det.

load_text(Text) :-
    setup_call_cleanup(
        tmp_file_stream(File, Stream, [encoding(utf8), extension(pl)]),
        ( format(Stream, "~s", [Text]),
          close(Stream),
          load_theory(File) ),
        delete_file(File)).
