:- module(session_shell_words,
          [ shell_word/2                % +Word, -Quoted
          ]).
/** <module> Words of a command that a person is told, to be pasted into a shell */

%!  shell_word(+Word, -Quoted) is det.
%
%   An atom as a shell reads it again: what it would take apart or change stands in quotes.

shell_word(Word, Word) :-
    Word \== '',
    forall(sub_atom(Word, _, 1, _, Char), ( char_type(Char, csym) ; sub_atom('-./:,=+@%', _, 1, _, Char) )),
    !.
shell_word(Word, Quoted) :-
    atomic_list_concat(Parts, '\'', Word),
    atomic_list_concat(Parts, '\'"\'"\'', Inner),
    atomic_list_concat(['\'', Inner, '\''], Quoted).
