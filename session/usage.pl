:- module(session_usage,
          [ usage_error/2,              % +Format, +Arguments
            dashes/2,                   % +Name, -Dashed
            did_you_mean/3              % +Name, +Known, -Hint
          ]).
/** <module> What is wrong with how a session was asked for */

:- use_module(library(lists), [member/2]).

%!  usage_error(+Format, +Arguments) is det.
%
%   @error usage_error(Message) always

usage_error(Format, Arguments) :-
    format(string(Message), Format, Arguments),
    throw(error(usage_error(Message), _)).

%!  dashes(+Name, -Dashed) is det.
%
%   The name of an option as it is written on a command line.

dashes(Name, Dashed) :-
    atomic_list_concat(Words, '_', Name),
    atomic_list_concat(Words, -, Dashed).

%!  did_you_mean(+Name, +Known, -Hint) is det.
%
%   Hint is a sentence with a blank before it where one of Known is spelt much like Name, else empty.

did_you_mean(Name, Known, Hint) :-
    (   member(Near, Known),
        dwim_match(Name, Near)
    ->  format(atom(Hint), " Did you mean ~w?", [Near])
    ;   Hint = ''
    ).
