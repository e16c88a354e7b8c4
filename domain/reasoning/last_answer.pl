:- module(domain_last_answer, [last_answer/4]).  % +Name, +Question, :Goal, -Answer

/** <module> The last answer to a question, for who asks it again

What was calculated to choose settings is asked for again by who tells why they were chosen.
*/

:- meta_predicate last_answer(+, +, 1, -).

%!  last_answer(+Name, +Question, :Goal, -Answer) is semidet.
%
%   The Answer that call(Goal, Answer) gives; without the call where the last Question under this Name was the same.

last_answer(Name, Question, _, Answer) :-
    nb_current(Name, Question0-Answer0),
    Question0 == Question,
    !,
    Answer = Answer0.
last_answer(Name, Question, Goal, Answer) :-
    call(Goal, Answer),
    nb_setval(Name, Question-Answer).
