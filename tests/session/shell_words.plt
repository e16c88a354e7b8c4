:- module(test_session_shell_words, []).
:- use_module(library(plunit)).
:- use_module(library(process)).
:- use_module(library(readutil), [read_stream_to_codes/2]).
:- use_module('../../session/shell_words').

/** <module> A shell reads the words that it is told */

:- begin_tests(shell_words).

test(is_read_again, [forall(member(Word, ['', run, '/tmp/a b', 'it\'s $1', 'a;b|c', 'übung', '~', '*'])), true(Read == Word)]) :-
    shell_word(Word, Quoted),
    atomic_list_concat(['printf %s ', Quoted], Command),
    setup_call_cleanup(process_create(path(sh), ['-c', Command], [stdout(pipe(Out, [encoding(utf8)]))]),
                       read_stream_to_codes(Out, Codes),
                       close(Out)),
    atom_codes(Read, Codes).

test(is_left_as_it_is, [forall(member(Word, ['--seed=3', '/tmp/run-1/x.toml', 'a,b:c@d+e%f']))]) :-
    shell_word(Word, Word).

:- end_tests(shell_words).
