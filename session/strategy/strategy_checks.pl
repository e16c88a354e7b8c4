:- module(session_strategy_checks,
          [ check_includes/1,           % +File
            check_control/1,            % +File
            check_against_device/2      % +File, +Device
          ]).
/** <module> What is wrong with a strategy, said in plain words with the place in its file before anything runs

The interpreter checks what any program can get wrong; here is what only the theory of lights and camera knows.
*/

:- use_module(not_offered, [light_names/2, no_light/3, settings_problem/3]).
:- use_module(strategy_file, [in_strategy/3, in_strategy/4, strategy_files/2]).
:- use_module('../usage_errors', [usage_error/2]).
:- use_module('../../indigolog/tools/formula_checks', [known_beforehand/2]).
:- use_module(library(lists), [member/2, memberchk/2]).

%!  check_includes(+File) is det.
%
%   @error usage_error(Message) where a file includes itself, or one that includes it: it can only be asked before it is loaded

check_includes(File) :-
    strategy_files(File, _).

%!  check_control(+File) is det.
%
%   @error usage_error(Message) where the strategy has no `control`

check_control(File) :-
    findall(Name, ( in_strategy(File, proc(Head, _), _), callable(Head), functor(Head, Name, 0) ), Names),
    (   memberchk(control, Names)
    ->  true
    ;   ( member(Near, Names), dwim_match(Near, control) -> format(atom(Hint), " Is ~w meant for it?", [Near]) ; Hint = '' ),
        usage_error("~w: it defines no `control`, the procedure that a session runs: proc(control, [...]).~w",
                    [File, Hint])
    ).

%!  check_against_device(+File, +Device) is det.
%
%   What the strategy names is there.
%
%   @error usage_error(Message)

check_against_device(File, Device) :-
    light_names(Device, Names),
    forall(( in_strategy(File, working(Light), Clause, Place), atom(Light), known_beforehand(Light, Clause),
             \+ memberchk(Light, Names) ),
           ( format(atom(Where), "~w: working(~w)", [Place, Light]), no_light(Where, Light, Names) )),
    forall(( member(Action-Settings, [choose(Settings)-Settings, capture(_, Settings)-Settings]),
             in_strategy(File, Action, Clause, Place),
             known_beforehand(Settings, Clause),
             settings_problem(Device, Settings, Problem) ),
           usage_error("~w: ~s", [Place, Problem])).

%   Of a predicate of the strategy that takes the place of one that the theory calls.
:- multifile prolog:message//1.

prolog:message(ignored_weak_import(_, From:Helper)) -->
    { sub_atom(From, 0, _, _, domain_) },
    [ '~q is a helper of the theory, whose procedures call this one now: another name is needed'-[Helper] ].
