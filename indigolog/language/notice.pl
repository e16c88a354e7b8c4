:- module(indigolog_notice,
          [ progress_message/1,       % +Message
            warn_once/3               % +Told, +About, +Message
          ]).
/** <module> Telling what is going on, for those who asked */

:- use_module(library(debug), [debugging/1, debugging/2, nodebug/1]).
:- use_module(library(lists), [memberchk/2]).

% So that it is a known topic, too, where this file was compiled before it is loaded.
:- ( debugging(indigolog, _) -> true ; nodebug(indigolog) ).

%!  progress_message(+Message) is det.
%
%   Printed after `debug(indigolog)`.

progress_message(Message) :-
    (   debugging(indigolog)
    ->  print_message(informational, golog(progress(Message)))
    ;   true
    ).

%!  warn_once(+Told, +About, +Message) is det.
%
%   Print a warning, unless there was one about the same before.  Told is told(List), to which About is added.

warn_once(Told, About, Message) :-
    arg(1, Told, Before),
    (   memberchk(About, Before)
    ->  true
    ;   nb_setarg(1, Told, [About|Before]),
        print_message(warning, Message)
    ).
