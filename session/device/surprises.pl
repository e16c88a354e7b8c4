:- module(session_surprises,
          [ surprised/3,                % +Image, +Result, -Event
            judge_model/2,              % +Images, +Result
            new_surprises/1,            % -Events
            recall_surprises/1,         % +History
            forget_surprises/0
          ]).
/** <module> What the vision server finds surprising, as exogenous actions

An image that is not as it was foreseen, and its likely cause; a model that does not fit.  The journal has them with
the image: what is killed before the event is met meets it when it goes on.
*/

:- use_module('../servers/restoration', [unmet_surprise/2]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [last/2, memberchk/2]).

:- dynamic
    unreported/1,                       % exogenous action
    told_of_model/0.                    % the strategy knows that the model does not fit

%!  surprised(+Image, +Result, -Event) is semidet.
%
%   Result, of the capture of Image, tells of Event, which is noted.  It is surprise(Since, Cause), or doubt(Since, Cause)
%   where the cause is not sure.

surprised(Image, Result, Event) :-
    once(event(Image, Result, Event)),
    assertz(unreported(Event)).

event(Image, Result, surprise(Since, Cause)) :-
    cause_told(Image, Result.get(surprise), Since, Cause).
event(Image, Result, doubt(Since, Cause)) :-
    cause_told(Image, Result.get(doubt), Since, Cause).

cause_told(Image, Told, Since, Cause) :-
    is_dict(Told),
    maplist(atom_string, Words, [Told.cause|Told.get(lights, [])]),
    Cause =.. Words,
    atom_string(Since, Told.get(since, Image)).

%!  judge_model(+Images, +Result) is det.
%
%   Note once that the model does not fit, where Result, of an estimate from Images, says so.

judge_model(Images, Result) :-
    Wrong = Result.get(model_wrong),
    is_dict(Wrong),
    \+ told_of_model,
    !,
    assertz(told_of_model),
    last(Images, Newest),
    atom_string(Axis, Wrong.axis),
    assertz(unreported(surprise(Newest, model_wrong(Axis, Wrong.share)))).
judge_model(_, _).

%!  new_surprises(-Events) is det.
%
%   Those that were noted since the last call.

new_surprises(Events) :-
    findall(Event, retract(unreported(Event)), Events).

%!  recall_surprises(+History) is det.
%
%   Take over those of a session that was interrupted; History has its actions, newest first.

recall_surprises(History) :-
    forall(unmet_surprise(History, Event), assertz(unreported(Event))),
    ( memberchk(surprise(_, model_wrong(_, _)), History) -> assertz(told_of_model) ; true ).

%!  forget_surprises is det.

forget_surprises :-
    retractall(unreported(_)),
    retractall(told_of_model).
