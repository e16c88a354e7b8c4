:- module(session_ending_words,
          [ error_line/2,               % +Error, -Line
            error_text/2,               % +Error, -Text
            plain_error/2,              % +Error, -Plain
            why_stopped/2               % +How, -Text
          ]).
/** <module> Why a session ended before its end, in words */

%!  error_text(+Error, -Text) is det.
%
%   The message of an error, without the word ERROR before it.

error_text(Error, Text) :-
    phrase('$messages':translate_message(Error), Lines),
    with_output_to(string(Shown), print_message_lines(current_output, '', Lines)),
    split_string(Shown, "", " \n", [Text]).

%!  error_line(+Error, -Line) is det.
%
%   The same in one line.

error_line(Error, Line) :-
    error_text(Error, Text),
    split_string(Text, "\n", " ", Lines),
    atomic_list_concat(Lines, ' ', Atom),
    atom_string(Atom, Line).

%!  plain_error(+Error, -Plain) is det.
%
%   Where in the program it was tells something about a program's error, not a server's.

plain_error(error(Formal, _), Plain), Formal \= golog(_) =>
    Plain = error(Formal, _).
plain_error(Error, Plain) =>
    Plain = Error.

%!  why_stopped(+How, -Text) is semidet.
%
%   In one line; How is stopped(Signal) or failed(Error).

why_stopped(stopped(int), Text) =>
    Text = "Stopped by Ctrl-C.".
why_stopped(stopped(_), Text) =>
    Text = "Stopped by SIGTERM, or in its view.".
why_stopped(failed(stopped(Signal)), Text) =>
    why_stopped(stopped(Signal), Text).
why_stopped(failed(Error), Text) =>
    plain_error(Error, Plain),
    error_line(Plain, Text).
why_stopped(_, _) =>
    fail.
