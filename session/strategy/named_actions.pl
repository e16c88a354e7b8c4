:- module(session_named_actions,
          [ check_chosen/1,             % +File
            check_parameters/2,         % +File, :Known
            doing/1,                    % +Action
            no_settings/2,              % +Chosen, -Words
            refused_action/3            % +Error, +File, -Message
          ]).
/** <module> Actions of the theory that a strategy names itself, and the servers' word on what it gives them

take_image, measure and the other procedures give their actions what they should have: what a strategy writes itself,
as set_parameter(matcher, genetic), it is answerable for.
*/

:- use_module(strategy_file, [in_strategy/3, place_of/3, program_part/4]).
:- use_module('../usage_errors', [did_you_mean/3, usage_error/2]).
:- use_module('../../indigolog/tools/formula_checks', [known_within/2]).
:- use_module('../../indigolog/tools/program_parts', [part_within/3]).
:- use_module(library(lists), [member/2, memberchk/2]).
:- use_module(library(occurs), [occurrences_of_term/3, occurrences_of_var/3]).

:- meta_predicate check_parameters(+, 1).

%!  check_chosen(+File) is det.
%
%   What the strategy chooses has a value, where its own words tell.  The theory of File is loaded.
%
%   @error usage_error(Message)

check_chosen(File) :-
    (   no_value(File, Chosen, Place, Why)
    ->  ( var(Chosen) -> Name = '_' ; Name = Chosen ),
        usage_error("~w: choose(~w): ~w", [Place, Name, Why])
    ;   true
    ).

%   No axiom of the theory gives the settings of choose/1 a value, as that of keep/1 gives one to its image.
no_value(File, Name, Place, Why) :-
    program_part(File, choose(Name), Around, Place),
    atom(Name),
    known_within(Name, Around),
    format(atom(Why), "~w is no fluent, and nothing around it binds it: it has no settings to choose", [Name]).
no_value(File, Chosen, Place, "pi binds it, and nothing before gives it a value: that takes a domain or a test") :-
    program_part(File, choose(Chosen), Around, Place),
    ( atom(Chosen) ; var(Chosen) ),
    member(Pick, Around),
    picks(Pick, Variable, Picked),
    Variable == Chosen,
    findall(chosen, ( part_within(Picked, choose(One), _), One == Variable ), All),
    length(All, Uses),
    uses(Variable, Picked, Uses).

picks(pi(Variable, Picked), Variable, Picked).
picks(rpi(Variable, Picked), Variable, Picked).

uses(Variable, Program, Count) :-
    (   var(Variable)
    ->  occurrences_of_var(Variable, Program, Count)
    ;   occurrences_of_term(Variable, Program, Count)
    ).

%!  no_settings(+Chosen, -Words) is semidet.
%
%   What is said of a choice of something else than settings, once the strategy runs.

no_settings(Chosen, "choose is given no settings: a variable in it has no value, as nothing before it gives it one") :-
    \+ ground(Chosen),
    !.
no_settings(Chosen, Words) :-
    Chosen \= settings(_, _, _),
    format(string(Words), "choose(~w): that is no settings, as settings(Levels, Shutter, Aperture) are", [Chosen]).

%!  check_parameters(+File, :Known) is det.
%
%   The vision server has the parameters that the strategy sets.  Known is called for their names only where it sets one.
%
%   @error usage_error(Message)

check_parameters(File, Known) :-
    findall(Name-Place, parameter_set(File, Name, Place), Set),
    (   Set == []
    ->  true
    ;   call(Known, Names),
        forall(( member(Name-Place, Set), \+ memberchk(Name, Names) ),
               no_parameter(Place, Name, Names))
    ).

parameter_set(File, Name, Place) :-
    program_part(File, set_parameter(Name, _), Around, Place),
    atom(Name),
    known_within(Name, Around).

no_parameter(Place, Name, Names) :-
    atomic_list_concat(Names, ', ', Listed),
    did_you_mean(Name, Names, Hint),
    usage_error("~w: there is no vision parameter ~w; there are ~w.~w", [Place, Name, Listed, Hint]).

%!  doing(+Action) is det.
%
%   Action is what the servers are asked for, `none` when it is done.

doing(Action) :-
    nb_setval(session_doing, Action).

%!  refused_action(+Error, +File, -Message) is semidet.
%
%   Error is the word of a server that an action cannot be done as it was asked for, and the strategy names that action.

refused_action(error(server_error(Code, Said, Hint), _), File, Message) :-
    memberchk(Code, [bad_arguments, bad_input]),
    nb_current(session_doing, Action),
    compound(Action),
    compound_name_arity(Action, Name, Arity),
    compound_name_arity(Like, Name, Arity),
    in_strategy(File, Like, _),
    !,
    place_of(File, [Action, Like], Place),
    format(string(Text), "~w: ~q is refused: ~w ~w", [Place, Name/Arity, Said, Hint]),
    split_string(Text, "", " ", [Message]).
