:- module(indigolog_run_options,
          [ known_options/1,          % +Options
            known_device_options/2    % +Module, +Options
          ]).
/** <module> The options of a run and of a device are known, and have values that they can have */

:- use_module(library(error), [must_be/2]).
:- use_module(library(lists), [member/2]).

%!  known_options(+Options) is det.
%
%   @error golog(unknown_option(Option)), golog(option_value(Option, What))

known_options(Options) :-
    all_known(Options, run_option, =).

% all_known(+Options, :Table, :Named): Named makes of an option that is not in Table what it is told by.
all_known(Options, Table, Named) :-
    must_be(list, Options),
    forall(member(Option, Options), known(Option, Table, Named)).

known(Option, Table, Named) :-
    (   callable(Option),
        functor(Option, Name, Arity),
        call(Table, Name/Arity, Kind)
    ->  arg(1, Option, Value),
        right_value(Kind, Value, Option)
    ;   call(Named, Option, What),
        throw(error(golog(unknown_option(What)), _))
    ).

% run_option(?Indicator, ?Kind): theory/1 and check/1 are for indigolog/2.
run_option(theory/1, any).
run_option(check/1, truth).
run_option(run/1, any).
run_option(device/1, any).
run_option(device/2, any).
run_option(deadline/1, seconds).
run_option(journal/1, file).
run_option(resume/1, file).
run_option(replay/1, file).
run_option(follow/1, any).
run_option(seed/1, integer).
run_option(max_actions/1, count(inf)).
run_option(max_silent/1, count(default)).
run_option(max_wait/1, wait).
run_option(on_action/1, any).
run_option(on_fact/1, any).
run_option(history/1, any).
run_option(situation/1, any).
run_option(rest/1, any).
run_option(outcome/1, any).

%!  known_device_options(+Module, +Options) is det.
%
%   @error golog(unknown_option(Option)), golog(option_value(Option, What))

known_device_options(Module, Options) :-
    all_known(Options, device_option, of_device(Module)).

of_device(Module, Option, device(Module, [Option])).

device_option(thread/1, truth).
device_option(deadline/1, seconds).

right_value(Kind, Value, Option) :-
    (   ( Kind == any ; nonvar(Value), is_a(Kind, Value) )
    ->  true
    ;   in_words(Kind, What),
        throw(error(golog(option_value(Option, What)), _))
    ).

is_a(truth, Value) :- ( Value == true ; Value == false ).
is_a(seconds, Value) :- number(Value), Value > 0.
is_a(wait, Value) :- ( Value == inf ; number(Value), Value >= 0 ).
is_a(count(Other), Value) :- ( Value == Other ; integer(Value), Value >= 0 ).
is_a(integer, Value) :- integer(Value).
is_a(file, Value) :- ( atom(Value), Value \== '' ; string(Value), Value \== "" ).

in_words(truth, 'true or false').
in_words(seconds, 'a number of seconds above 0').
in_words(wait, 'a number of seconds from 0, or inf').
in_words(count(Other), What) :- atom_concat('a whole number from 0, or ', Other, What).
in_words(integer, 'a whole number').
in_words(file, 'the name of a file').
