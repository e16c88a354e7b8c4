:- module(domain_outlook,
          [ worth_predicting/3,         % +Device, +Unfavourable, -Settings
            best_outlook/4              % +Device, +Unfavourable, +Foreseen, -Outlook
          ]).
/** <module> What is asked of images to come, and what is remembered of the answer

What settings would add is foreseen by the vision server, line by line; here is which settings it is asked of, and
which of those that it answers with are worth choosing.
*/

:- use_module(candidates, [candidate/2, unfavourable/3]).
:- use_module(library(apply), [exclude/3]).
:- use_module(library(lists), [append/3]).

remembered(5).                          % enough to see what was nearly chosen; by hand

%!  worth_predicting(+Device, +Unfavourable, -Settings) is det.
%
%   The representatives of all qualitative states but those like unfavourable ones.

worth_predicting(Device, Unfavourable, Settings) :-
    findall(S, ( candidate(Device, S), \+ unfavourable(Device, Unfavourable, S) ), Settings).

%!  best_outlook(+Device, +Unfavourable, +Foreseen, -Outlook) is det.
%
%   The best of adds(Bits, Settings, Line), best first, but for those of states like unfavourable ones.

best_outlook(Device, Unfavourable, Foreseen, Outlook) :-
    exclude(adds_unfavourably(Device, Unfavourable), Foreseen, Left),
    sort(1, @>=, Left, Sorted),
    remembered(Most),
    length(Best, Most),
    ( append(Best, _, Sorted) -> Outlook = Best ; Outlook = Sorted ).

adds_unfavourably(Device, Unfavourable, adds(_, Settings, _)) :-
    unfavourable(Device, Unfavourable, Settings).
