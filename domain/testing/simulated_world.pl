:- module(simulated_world,
          [ in_world/5,                 % +Options, :Controller, +Program, -Outcome, -Situation
            settings_taken/2,           % +Situation, -Settings
            testbed/1,                  % -Device
            can_execute/1,              % +Action
            execute/2,                  % +Action, -Sensing
            exogenous/1                 % -Actions
          ]).
/** <module> A small world for strategies: light adds up, and images that are neither dark nor glaring fix the pose

The target's linear brightness is exposure × (sun + the mean of the lights), its brightest part is 1.8 times that.  An
image tells as much as it is neither dark nor saturated; a set's errors fall with the sum of what its images tell.
*/

:- use_module('../../indigolog/indigolog').
:- use_module('../reasoning/device').
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/3, member/2, reverse/2, sum_list/2]).
:- use_module(library(option), [option/3]).

:- dynamic
    setting/1,                          % Option of the world
    image/2,                            % Name, Settings
    range/1,                            % m
    parameter/2,                        % Name, Value: of the vision server
    pending/1.                          % Event to happen

:- meta_predicate in_world(+, :, +, -, -).

%!  in_world(+Options, :Controller, +Program, -Outcome, -Situation) is det.
%
%   Run Program of a controller in a new world; Situation is the last one.  Controller is a name in domain/controllers,
%   or a file that ends in `.pl`, looked for beside the test that asks.  Options:
%   sun(Brightness) at the reference exposure (0.02), images(Most) that may be taken (10), threshold(Px) (1.0),
%   seed(N) (1), happens(Event, Image) when that image is taken, blind_below(RangeM): no pose nearer than that, and
%   cured_by(Parameter, Value): until the vision server is told so an image tells a fifth;
%   useless: every image after the first tells nothing; harmful: makes the pose worse; nothing_foreseen: no prediction;
%   rival(Chance): another pose is so likely beside that which is found (0).

in_world(Options, Controller, Program, Outcome, Situation) :-
    maplist(retractall, [setting(_), image(_, _), range(_), parameter(_, _), pending(_)]),
    forall(member(Option, Options), assertz(setting(Option))),
    load(Controller),
    nb_setval(world_situation, none),
    option(seed(Seed), Options, 1),
    indigolog(Program,
              [ device(simulated_world), seed(Seed), outcome(Outcome), on_action(simulated_world:after_action) ]),
    nb_getval(world_situation, Situation).

load(Test:Controller) :-
    domain_folder(Domain),
    (   file_name_extension(_, pl, Controller)
    ->  ( module_property(Test, file(Asking)) -> file_directory_name(Asking, Beside) ; Beside = '.' ),
        absolute_file_name(Controller, Strategy, [relative_to(Beside)])
    ;   format(atom(Strategy), "~w/controllers/~w.pl", [Domain, Controller])
    ),
    findall(File, ( member(Name, [acquisition, procedures, approach]), format(atom(File), "~w/~w.pl", [Domain, Name]) ), Files),
    append(Files, [Strategy], Theory),
    load_theory(Theory).

domain_folder(Domain) :-
    module_property(simulated_world, file(Here)),
    file_directory_name(Here, Testing),
    file_directory_name(Testing, Domain).

%!  settings_taken(+Situation, -Settings) is det.
%
%   The settings of all images taken, oldest first.

settings_taken(Situation, Settings) :-
    situation_history(Situation, Newest),
    findall(S, member(capture(_, S), Newest), Back),
    reverse(Back, Settings).

%!  testbed(-Device) is det.
%
%   The paper's: three lights of eight levels, five shutters, three apertures.

testbed(device([light(left, 8), light(right, 8), light(top, 8)],
               [0.0041667, 0.0083333, 0.0166667, 0.0333333, 0.0666667],
               [2.8, 4.0, 5.6],
               sensor(2.0, 6.0, 10000.0, 1.0),
               exposure(0.0166667, 4.0),
               0.001)).

:- public after_action/2.

after_action(_, Situation) :-
    nb_setval(world_situation, Situation).

                /*******************************
                *            DEVICE            *
                *******************************/

can_execute(connect).
can_execute(capture(_, _)).
can_execute(estimate(_)).
can_execute(predict(_, _, _)).
can_execute(appraise(_)).
can_execute(set_parameter(_, _)).
can_execute(discard(_, _)).
can_execute(advance(_)).

execute(connect, session(Device, Threshold, Most)) :-
    testbed(Device),
    world(threshold(Threshold), 1.0),
    world(images(Most), 10).
execute(capture(Image, Settings), Statistics) :-
    assertz(image(Image, Settings)),
    forall(setting(happens(Event, Image)), assertz(pending(Event))),
    seen(Settings, Statistics).
execute(estimate(Images), Fix) :-
    aggregate_all(sum(Worth), ( member(Image, Images), worth(Image, Worth) ), Told),
    fix(Told, Fix).
% Light from the left is what is foreseen to add most, while it is not known to be bad.
execute(predict(_, States, [_|_]), [adds(2.5, settings([7, 1, 0], 0.0166667, 4.0), 3)]) :-
    \+ setting(nothing_foreseen),
    \+ member(state(_, from(left), _), States),
    !.
execute(predict(_, _, _), []).
% Gradients are richest at a quarter of full scale.
execute(appraise(Image), Gamma) :-
    image(Image, Settings),
    seen(Settings, statistics(P50, _, _, _, _)),
    Gamma is max(0.53, min(1.9, (P50 / 0.25) ** 0.5)).
execute(set_parameter(Name, Value), true) :-
    retractall(parameter(Name, _)),
    assertz(parameter(Name, Value)).
execute(discard(_, _), true).
execute(advance(Range), true) :-
    retractall(range(_)),
    assertz(range(Range)).

exogenous(Events) :-
    findall(Event, retract(pending(Event)), Events).

world(Option, Default) :-
    (   setting(Option)
    ->  true
    ;   arg(1, Option, Default)
    ).

seen(Settings, statistics(P50, P95, Dark, Saturated, BlurPx)) :-
    testbed(Device),
    Settings = settings(Levels, Shutter, Aperture),
    level_fractions(Device, Levels, Fractions),
    exposure_stops(Device, Settings, Stops),
    world(sun(Sun), 0.02),
    sum_list(Fractions, Light),
    Brightness is 2 ** Stops * (Sun + 0.5 * Light / 3),
    P50 is min(1.0, Brightness),
    P95 is min(1.0, 1.8 * Brightness),
    Dark is max(0.0, min(1.0, 1 - Brightness / 0.1)),
    Saturated is max(0.0, min(1.0, 1.8 * Brightness - 1)),
    BlurPx is sqrt(1 + (2.8 / Aperture) ** 2 + (Shutter * 60) ** 2).

worth(Image, -0.3) :-
    setting(harmful),
    Image \== i1,
    !.
worth(Image, 0.0) :-
    setting(useless),
    Image \== i1,
    !.
worth(Image, Worth) :-
    image(Image, Settings),
    seen(Settings, statistics(_, _, Dark, Saturated, _)),
    ( setting(cured_by(Name, Value)), \+ parameter(Name, Value) -> Share = 0.2 ; Share = 1 ),
    Worth is Share * (1 - Dark) * (1 - Saturated).

fix(_, no_pose) :-
    range(Range),
    setting(blind_below(Nearest)),
    Range < Nearest,
    !.
fix(Told, no_pose) :-
    Told < 0.1,
    !.
fix(Told, fix(pose([0.1, -0.2, 0.05], [0.0, 0.0, 0.6]), [], quality(Rms, Uncertainty, 1.0, Score, Chance), [])) :-
    ( setting(rival(Chance)) -> true ; Chance = 0.0 ),
    Rms is 0.2 + 0.4 / Told,
    Uncertainty is 0.001 / sqrt(Told),
    Score is (1 - 0.1 ** (Told + 0.5)) / (1 + Chance).
