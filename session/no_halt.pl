:- module(session_no_halt,
          [ without_halt/1              % :Goal
          ]).
/** <module> A strategy cannot end the process: its servers would be left, and its exit status be that of a pose found

Prolog's halt/1 is wrapped for all modules, so that a library that a strategy loads is no way around.
*/

:- use_module(library(prolog_wrap), [wrap_predicate/4]).

:- meta_predicate without_halt(0).

:- dynamic
    held/0.                             % Prolog is not to halt

:- wrap_predicate(system:halt(_), session, Halt, ( session_no_halt:held -> throw(error(strategy_halts, _)) ; Halt )).

%!  without_halt(:Goal) is semidet.
%
%   Call Goal once.
%
%   @error strategy_halts where halt/0 or halt/1 is called meanwhile

without_halt(Goal) :-
    setup_call_cleanup(assertz(held, Held), once(Goal), erase(Held)).

:- multifile prolog:error_message//1.

prolog:error_message(strategy_halts) -->
    [ 'a strategy may not call halt: a session ends when its `control` does'-[] ].
