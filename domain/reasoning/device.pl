:- module(domain_device,
          [ device_lights/2,            % +Device, -Lights
            device_shutters/2,          % +Device, -ShuttersS
            device_apertures/2,         % +Device, -Apertures
            device_sensor/2,            % +Device, -Sensor
            device_reference/2,         % +Device, -Exposure
            full_levels/2,              % +Device, -Levels
            middle_levels/2,            % +Device, -Levels
            light_count/2,              % +Device, -Count
            only_light/3,               % +Device, +Index, -Levels
            level_fractions/3,          % +Device, +Levels, -Fractions
            exposure_stops/3,           % +Device, +Settings, -Stops
            random_settings/2,          % +Device, -Settings
            reference_settings/2,       % +Device, -Settings
            settings_in_range/2,        % +Device, +Settings
            lit_settings/3,             % +Device, +Settings, -Lit
            without_light/3,            % +Device, +Light, -Darker
            unlit/4                     % +Device, +Light, +Settings, -Unlit
          ]).
/** <module> What a camera with controllable lights can do

A device is described by its image server and is, here, the term

    device(Lights, Shutters, Apertures, Sensor, Reference, Tolerance)

with `Lights` a list of light(Name, Levels), `Levels` being dead(N) for one of N levels that failed, `Shutters` in seconds,
`Apertures` as f-numbers, `Sensor` = sensor(Gain, ReadNoiseE, FullWellE, Gamma) and
`Reference` = exposure(ShutterS, Aperture), the exposure that counts as zero
stops.  A shutter or aperture that differs by no more than the fraction `Tolerance`
from one that is offered is that one.  Nothing here assumes a number of lights.

Settings are settings(Levels, ShutterS, Aperture), one level per light.
*/

:- use_module(library(apply), [maplist/2, maplist/3, maplist/4]).
:- use_module(library(lists), [member/2, same_length/2]).
:- use_module(library(random), [random_between/3, random_member/2]).
:- set_prolog_flag(optimise, true).     % arithmetic is compiled, here alone

%!  device_lights(+Device, -Lights) is det.
device_lights(device(Lights, _, _, _, _, _), Lights).

%!  device_shutters(+Device, -ShuttersS) is det.
device_shutters(device(_, Shutters, _, _, _, _), Shutters).

%!  device_apertures(+Device, -Apertures) is det.
device_apertures(device(_, _, Apertures, _, _, _), Apertures).

%!  device_sensor(+Device, -Sensor) is det.
device_sensor(device(_, _, _, Sensor, _, _), Sensor).

%!  device_reference(+Device, -Exposure) is det.
device_reference(device(_, _, _, _, Reference, _), Reference).

%!  full_levels(+Device, -Levels) is det.
%
%   Every light at its highest level.

full_levels(Device, Levels) :-
    device_lights(Device, Lights),
    maplist(full_level, Lights, Levels).

full_level(light(_, dead(_)), Level) =>
    Level = 0.
full_level(light(_, N), Level) =>
    Level is N - 1.

%!  middle_levels(+Device, -Levels) is det.
%
%   Every light half way up; a light with one level is on.

middle_levels(Device, Levels) :-
    device_lights(Device, Lights),
    maplist(middle_level, Lights, Levels).

middle_level(light(_, dead(_)), Level) =>
    Level = 0.
middle_level(light(_, N), Level) =>
    Level is N // 2.

%!  light_count(+Device, -Count) is det.

light_count(Device, Count) :-
    device_lights(Device, Lights),
    length(Lights, Count).

%!  only_light(+Device, +Index, -Levels) is semidet.
%
%   The Index-th light (from 1) full, the others off.

only_light(Device, Index, Levels) :-
    full_levels(Device, Full),
    only(Full, Index, Levels).

only([Full|Rest], 1, Levels) =>
    Levels = [Full|Off],
    same_length(Rest, Off),
    maplist(=(0), Off).
only([_|Rest], Index, Levels) =>
    Levels = [0|More],
    Before is Index - 1,
    only(Rest, Before, More).
only([], _, _) =>
    fail.

%!  level_fractions(+Device, +Levels, -Fractions) is det.
%
%   Each light's output as a fraction of its full output.  What images were taken under before a light died was lit by it.

level_fractions(Device, Levels, Fractions) :-
    device_lights(Device, Lights),
    maplist(level_fraction, Lights, Levels, Fractions).

level_fraction(light(_, dead(N)), Level, Fraction) =>
    level_fraction(light(_, N), Level, Fraction).
level_fraction(light(_, 1), _, Fraction) =>
    Fraction = 1.0.                     % it cannot be dimmed
level_fraction(light(_, N), Level, Fraction) =>
    Fraction is float(Level) / (N - 1).

%!  exposure_stops(+Device, +Settings, -Stops) is det.
%
%   How much more light than the reference exposure lets in, as a power of two: the law of stack/exposure.py, whose
%   reference the device tells.

exposure_stops(Device, settings(_, Shutter, Aperture), Stops) :-
    device_reference(Device, exposure(Shutter0, Aperture0)),
    Stops is log((Shutter / Aperture ** 2) / (Shutter0 / Aperture0 ** 2)) / log(2).

%!  random_settings(+Device, -Settings) is det.
%
%   Every setting drawn evenly and alone: the paper's choice for a first image.

random_settings(Device, settings(Levels, Shutter, Aperture)) :-
    device_lights(Device, Lights),
    device_shutters(Device, Shutters),
    device_apertures(Device, Apertures),
    maplist(random_level, Lights, Levels),
    random_member(Shutter, Shutters),
    random_member(Aperture, Apertures).

random_level(Light, Level) :-
    full_level(Light, Top),
    random_between(0, Top, Level).

%!  reference_settings(+Device, -Settings) is det.
%
%   All lights half way up, and the exposure nearest to the reference.

reference_settings(Device, settings(Levels, Shutter, Aperture)) :-
    Device = device(_, Shutters, Apertures, _, exposure(Shutter0, Aperture0), _),
    middle_levels(Device, Levels),
    nearest(Shutter0, Shutters, Shutter),
    nearest(Aperture0, Apertures, Aperture).

nearest(Wanted, [First|Rest], Nearest) :-
    nearest_of(Rest, Wanted, First, Nearest).

nearest_of([], _, Nearest, Nearest).
nearest_of([Value|Values], Wanted, Best, Nearest) :-
    (   abs(log(Value / Wanted)) < abs(log(Best / Wanted))
    ->  nearest_of(Values, Wanted, Value, Nearest)
    ;   nearest_of(Values, Wanted, Best, Nearest)
    ).

%!  settings_in_range(+Device, +Settings) is semidet.
%
%   True when the device offers these settings.  A dead light may have any level, since it may have died after the
%   settings were thought of: see lit_settings/3.

settings_in_range(Device, settings(Levels, Shutter, Aperture)) :-
    device_lights(Device, Lights),
    maplist(level_in_range, Lights, Levels),
    offered_exposure(Device, Shutter, Aperture, _, _).

offered_exposure(device(_, Shutters, Apertures, _, _, Tolerance), Shutter0, Aperture0, Shutter, Aperture) :-
    offered(Shutter0, Shutters, Tolerance, Shutter),
    offered(Aperture0, Apertures, Tolerance, Aperture).

level_in_range(light(_, dead(_)), Level) =>
    integer(Level),
    Level >= 0.
level_in_range(Light, Level) =>
    full_level(Light, Top),
    integer(Level),
    between(0, Top, Level).

offered(Value, Values, Tolerance, Offered) :-
    member(Offered, Values),
    abs(Value - Offered) =< Tolerance * max(Value, Offered),
    !.

%!  lit_settings(+Device, +Settings, -Lit) is det.
%
%   The same settings, which are in range, with the exposure as it is offered and every dead light at 0.

lit_settings(Device, settings(Levels, Shutter0, Aperture0), settings(Lit, Shutter, Aperture)) :-
    offered_exposure(Device, Shutter0, Aperture0, Shutter, Aperture),
    device_lights(Device, Lights),
    maplist(lit_level, Lights, Levels, Lit).

lit_level(light(_, dead(_)), _, Lit) =>
    Lit = 0.
lit_level(_, Level, Lit) =>
    Lit = Level.

%!  without_light(+Device, +Light, -Darker) is det.
%
%   The device with one light dead: it stays in its place and is always off.

without_light(device(Lights0, Shutters, Apertures, Sensor, Reference, Tolerance), Light,
              device(Lights, Shutters, Apertures, Sensor, Reference, Tolerance)) :-
    maplist(kill(Light), Lights0, Lights).

kill(Light, light(Light, Levels), Dead) =>
    ( Levels = dead(_) -> Dead = light(Light, Levels) ; Dead = light(Light, dead(Levels)) ).
kill(_, Light, Same) =>
    Same = Light.

%!  unlit(+Device, +Light, +Settings, -Unlit) is det.
%
%   The same settings with one light off.

unlit(Device, Light, settings(Levels0, Shutter, Aperture), settings(Levels, Shutter, Aperture)) :-
    device_lights(Device, Lights),
    maplist(unlit_level(Light), Lights, Levels0, Levels).

unlit_level(Light, light(Light, _), _, Level) =>
    Level = 0.
unlit_level(_, _, Level0, Level) =>
    Level = Level0.
