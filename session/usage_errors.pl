:- module(session_usage_errors,
          [ usage_error/2,              % +Format, +Arguments
            dashes/2,                   % +Name, -Dashed
            refused_by_server/1,        % +Formal
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

:- multifile prolog:error_message//1.

prolog:error_message(usage_error(Message)) -->
    { split_string(Message, "\n", "", Lines) },
    lines(Lines).

lines([Line]) -->
    !,
    [ '~s'-[Line] ].
lines([Line|Lines]) -->
    [ '~s'-[Line], nl ],
    lines(Lines).

%!  refused_by_server(+Formal) is semidet.
%
%   With exit status 2 a server has said what it was given that it cannot use: that is all there is to say.

refused_by_server(server_died(_, exit(2), Line, _)) :-
    Line \== "".

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
    (   between(0, 2, Edits),
        member(Near, Known),
        spelt_like(Edits, Name, Near)
    ->  format(atom(Hint), " Did you mean ~w?", [Near])
    ;   Hint = ''
    ).

%   A third of a name's letters at most: two of a short one make another name.
spelt_like(0, Name, Near) :-
    dwim_match(Name, Near).
spelt_like(Edits, Name, Near) :-
    Edits > 0,
    atom_codes(Name, Given),
    atom_codes(Near, Codes),
    length(Codes, Length),
    3 * Edits =< Length,
    edited(Given, Codes, Edits).

%   edited(+Codes, +Others, +Edits): so many letters at most are left out, put in or replaced.
edited(Codes, Codes, _) :- !.
edited([Code|Codes], [Code|Others], Edits) :-
    !,
    edited(Codes, Others, Edits).
edited(Codes, Others, Edits) :-
    Edits > 0,
    Left is Edits - 1,
    (   Codes = [_|Rest], edited(Rest, Others, Left)
    ;   Others = [_|Rest], edited(Codes, Rest, Left)
    ;   Codes = [_|Rest], Others = [_|Following], edited(Rest, Following, Left)
    ).
