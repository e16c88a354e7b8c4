:- module(session_not_offered,
          [ settings_problem/3,         % +Device, +Settings, -Problem
            light_names/2,              % +Device, -Names
            no_light/3,                 % +Where, +Light, +Names
            check_instead/2             % +Words, +Device
          ]).
/** <module> Lights and settings that are named and that the device does not offer, in words
*/

:- use_module('../usage_errors', [did_you_mean/3, usage_error/2]).
:- use_module('../../domain/reasoning/device').
:- use_module('../../domain/reasoning/instead', [instead_lights/2, instead_settings/3]).
:- use_module('../../domain/reasoning/qualitative', [settings_words/3, shutter_words/2]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, nth1/3]).

%!  settings_problem(+Device, +Settings, -Problem) is semidet.
%
%   Why Device cannot take Settings.  Only settings(...) are looked at: other terms are tests that choose some.

settings_problem(Device, settings(Levels, Shutter0, Aperture), Problem) :-
    is_list(Levels),
    catch(Shutter is Shutter0, error(_, _), fail),
    number(Aperture),
    \+ settings_in_range(Device, settings(Levels, Shutter, Aperture)),
    device_lights(Device, Lights),
    (   length(Lights, Count), \+ length(Levels, Count)
    ->  length(Levels, Given),
        light_names(Device, Names),
        atomic_list_concat(Names, ', ', Known),
        format(string(Problem), "settings with ~d light levels, but there are ~d lights: ~w", [Given, Count, Known])
    ;   nth1(N, Levels, Level), nth1(N, Lights, light(Name, Range)), integer(Range),
        \+ ( integer(Level), between(1, Range, Above), Level =:= Above - 1 )
    ->  Top is Range - 1,
        format(string(Problem), "light ~w has no level ~w; it has 0 to ~d", [Name, Level, Top])
    ;   device_shutters(Device, Shutters), \+ in_range_with(Device, Levels, Shutter, _)
    ->  maplist(shutter_words, Shutters, Words),
        atomic_list_concat(Words, ', ', Known),
        format(string(Problem), "a shutter of ~w s is not offered; there are ~w", [Shutter0, Known])
    ;   device_apertures(Device, Apertures),
        atomic_list_concat(Apertures, ', ', Known),
        format(string(Problem), "an aperture of ~w is not offered; there are ~w", [Aperture, Known])
    ).

in_range_with(Device, Levels, Shutter, Aperture) :-
    device_apertures(Device, Apertures),
    member(Aperture, Apertures),
    settings_in_range(Device, settings(Levels, Shutter, Aperture)),
    !.

%!  light_names(+Device, -Names) is det.

light_names(Device, Names) :-
    device_lights(Device, Lights),
    findall(Name, member(light(Name, _), Lights), Names).

%!  no_light(+Where, +Light, +Names) is det.
%
%   @error usage_error(Message)

no_light(Where, Light, Names) :-
    atomic_list_concat(Names, ', ', Known),
    did_you_mean(Light, Names, Hint),
    usage_error("~w: there is no light ~w; there are ~w.~w", [Where, Light, Known, Hint]).

%!  check_instead(+Words, +Device) is det.
%
%   The device offers the settings that an image is to be taken under instead of those that the strategy chooses.
%
%   @error usage_error(Message)

check_instead(Words, Device) :-
    (   instead_lights(Words, Named),
        append(_, [Twice|Others], Named),
        memberchk(Twice, Others)
    ->  usage_error("--instead: the light ~w is named twice", [Twice])
    ;   instead_settings(Words, Device, Settings)
    ->  (   settings_problem(Device, Settings, Problem)
        ->  usage_error("--instead: ~s", [Problem])
        ;   true
        )
    ;   instead_lights(Words, Named),
        light_names(Device, Names),
        member(Light, Named),
        \+ memberchk(Light, Names)
    ->  no_light('--instead', Light, Names)
    ;   reference_settings(Device, Example),
        settings_words(Device, Example, Shown),
        usage_error("--instead: '~w' does not tell lights, shutter and aperture, as 'i3: ~s' does", [Words, Shown])
    ).
