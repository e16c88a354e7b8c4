:- module(session_own_sensing,
          [ check_own_sensing/1         % +File
          ]).
/** <module> What a strategy senses by itself, beside lights and camera */

:- use_module('../device/acquisition_device', [can_execute/1]).
:- use_module(strategy_file, [in_strategy/3]).
:- use_module('../usage_errors', [usage_error/2]).
:- use_module(library(lists), [member/2]).

%!  check_own_sensing(+File) is det.
%
%   Each action of the strategy's own that senses has a clause of execute/2, without which a person would be asked.
%
%   @error usage_error(Message)

check_own_sensing(File) :-
    (   member(Axiom, [senses(Action, _), senses(Action, _, _, _, _)]),
        in_strategy(File, Axiom, Place),
        callable(Action),
        \+ can_execute(Action),
        \+ in_strategy(File, execute(Action, _), _)
    ->  functor(Action, Name, Arity),
        usage_error("~w: nothing tells what ~q senses: write a clause of execute/2 for it, which binds the result",
                    [Place, Name/Arity])
    ;   true
    ).
