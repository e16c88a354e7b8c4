:- module(indigolog_notice,
          [ progress_message/1        % +Message
          ]).
/** <module> Telling what is going on, for those who asked */

:- use_module(library(debug), [debugging/1]).

%!  progress_message(+Message) is det.
%
%   Printed after `debug(indigolog)`.

progress_message(Message) :-
    (   debugging(indigolog)
    ->  print_message(informational, golog(progress(Message)))
    ;   true
    ).
