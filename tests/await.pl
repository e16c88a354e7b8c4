:- module(test_await,
          [ await/1                   % :Goal
          ]).
/** <module> Waiting in a test for what another thread or process brings about */

:- use_module(library(time), [call_with_time_limit/2]).

:- meta_predicate await(0).

%!  await(:Goal) is det.
%
%   Goal is true now, or comes true.
%
%   @error time_limit_exceeded after a minute

await(Goal) :-
    call_with_time_limit(60, until(Goal)).

until(Goal) :-
    ( call(Goal) -> true ; sleep(0.01), until(Goal) ).
