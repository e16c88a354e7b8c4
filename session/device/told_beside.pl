:- module(session_told_beside,
          [ note_beside/3,              % +Images, +Fix, +Result
            told_beside/3,              % +Images, +Fix, -More
            forget_beside/0
          ]).
/** <module> What estimates tell beside their fix: other poses that fit, and turns that no image tells

It is for `result.json`, and no part of the history: an estimate of a session that goes on is asked for again.
*/

:- use_module('../json_terms', [fix_term/2]).
:- use_module('../servers/connections', [ask/4]).
:- use_module(library(lists), [member/2]).

:- dynamic
    noted/3.                            % Images, Fix, More

%!  note_beside(+Images, +Fix, +Result) is det.
%
%   Result, a reply to `estimate`, had this fix.

note_beside(Images, Fix, Result) :-
    more_of(Result, More),
    retractall(noted(Images, _, _)),
    assertz(noted(Images, Fix, More)).

%!  told_beside(+Images, +Fix, -More) is semidet.
%
%   More has those of `poses` and `free` that an estimate from these images told with its fix.

told_beside(Images, Fix, More) :-
    noted(Images, Fix, More),
    !.
told_beside(Images, Fix, More) :-
    catch(ask(vision_server, estimate, _{images:Images}, Result), error(_, _), fail),
    fix_term(Result, Again),
    Again == Fix,
    more_of(Result, More).

more_of(Result, More) :-
    findall(Key-Value, ( member(Key, [poses, free]), Value = Result.get(Key), Value \== [] ), Pairs),
    dict_pairs(More, more, Pairs).

%!  forget_beside is det.

forget_beside :-
    retractall(noted(_, _, _)).
