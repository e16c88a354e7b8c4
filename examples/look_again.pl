% What has changed unseen is seen before a session ends: the image that confirms a pose is taken under the settings of the
% first, where nothing can differ but what has changed.  The first image's lights are graded, so that two that are swapped
% differ, too.  The rest is `informed`, whose test images tell the cause.
%
%   swipl main.pl --controller examples/look_again.pl --scenario harsh --explain

proc(choose_first, pi(s, [?(graded(device, s)), choose(s)])).

proc(choose_next,
     if(doubted, choose_telling,
        if(decided, [if(likely, look_ahead, []), choose_again], choose_informative))).

proc(choose_again, if(readings = [], choose_first, pi(s, [?(first_settings(readings, s)), choose(s)]))).

proc(enough, and([neg(doubted), decided, looked_again(readings)])).

proc(decided, or(converged, spent)).

% Golog: the settings of `informed`'s first image with the lights graded, the last half as bright as the first.
proc(graded(Device, S), some(safe, and(safest(Device, safe), graded_lights(safe, S)))).

:- include('../domain/controllers/informed.pl').

% Plain Prolog.

graded_lights(settings(Levels, Shutter, Aperture), settings(Graded, Shutter, Aperture)) :-
    length(Levels, Count),
    numlist(1, Count, Numbers),
    maplist(graded_level(Count), Numbers, Levels, Graded).

graded_level(Count, N, Level, Graded) :-
    Graded is max(min(1, Level), round(Level * (1 - 0.5 * (N - 1) / max(1, Count - 1)))).

first_settings(Readings, Settings) :-
    last(Readings, reading(Settings, _)).

looked_again([reading(Settings, _)|Before]) :-
    first_settings(Before, Settings).
