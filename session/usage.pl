:- module(session_usage,
          [ usage_error/2,              % +Format, +Arguments
            dashes/2                    % +Name, -Dashed
          ]).

/** <module> What is wrong with how a session was asked for */

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
