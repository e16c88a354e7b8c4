:- module(indigolog_notice,
          [ progress_message/1        % +Message
          ]).
:- use_module(library(debug), [debugging/1]).

/** <module> Telling what is going on, for those who asked */

%!  progress_message(+Message) is det.
%
%   Printed after `debug(indigolog)`.

progress_message(Message) :-
    (   debugging(indigolog)
    ->  print_message(informational, golog(progress(Message)))
    ;   true
    ).
