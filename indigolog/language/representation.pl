:- module(indigolog_representation,
          [ theory_module/2,          % +Theory, -Module
            instances_module/2,       % +Theory, -Module
            initial_values/2,         % +Theory, -Trie
            plain_actions/2,          % +Theory, -Trie
            theory_certain/1,         % +Theory
            make_theory/5,            % +Module, +Home, +Tries, +Certainty, -Theory
            make_situation/6,         % +Theory, +Values, +History, +Length, +Open, -Situation
            situation_theory/2,       % +Situation, -Theory
            situation_module/2,       % +Situation, -Module
            situation_values/2,       % +Situation, -Values
            situation_history/2,      % +Situation, -History
            situation_length/2,       % +Situation, -Count
            situation_open/2,         % +Situation, -Open
            values_certain/1,         % +Situation
            same_situation/2,         % +Situation, +Situation1
            last_action/2             % +Situation, -Action
          ]).
/** <module> What theories and situations look like

Only here.  A theory is th(Module, Instances, tries(Initial, Plain), Certainty): the module
that holds the files, a module that holds the ground fluent instances (so that every
argument is indexed), the tries that remember initial values and plain actions (which only
a certain theory has), and `possible` if some fluent may have several possible values, else
`certain`.  A situation is s(Theory, Values, History, Length, Open), see situation.pl.

Each accessor is also unfolded where it is called, so that it costs nothing.
*/

:- use_module(library(lists), [memberchk/2]).
:- use_module(unfolding, [unfolded/2]).

make_theory(Module, Home, Tries, Certainty, th(Module, Home, Tries, Certainty)).
theory_module(th(Module, _, _, _), Module).
instances_module(th(_, Home, _, _), Home).
initial_values(th(_, _, tries(Initial, _), _), Initial).
plain_actions(th(_, _, tries(_, Plain), certain), Plain).
theory_certain(th(_, _, _, certain)).

make_situation(Theory, Values, History, N, Open, s(Theory, Values, History, N, Open)).
situation_theory(s(Theory, _, _, _, _), Theory).
situation_module(s(th(Module, _, _, _), _, _, _, _), Module).
situation_values(s(_, Values, _, _, _), Values).
situation_history(s(_, _, History, _, _), History).     % newest action first
situation_length(s(_, _, _, N, _), N).
situation_open(s(_, _, _, _, Open), Open).
values_certain(s(th(_, _, _, certain), _, _, _, _)).
same_situation(s(_, _, _, N, _), s(_, _, _, N, _)).     % no action in between
last_action(s(_, _, [A|_], _, _), A).

:- multifile system:goal_expansion/2.

system:goal_expansion(Goal, Unifications) :-
    callable(Goal),
    functor(Goal, Name, Arity),
    module_property(indigolog_representation, exports(Accessors)),
    memberchk(Name/Arity, Accessors),
    prolog_load_context(module, Module),
    predicate_property(Module:Goal, imported_from(indigolog_representation)),
    unfolded(indigolog_representation:Goal, Unifications).
