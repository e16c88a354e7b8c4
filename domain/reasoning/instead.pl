:- module(domain_instead,
          [ set_instead/1,              % +Words
            instead/3,                  % +Taken, +Device, -Settings
            instead_image/2,            % +Words, -Number
            instead_lights/2,           % +Words, -Names
            instead_settings/3          % +Words, +Device, -Settings
          ]).
/** <module> What if: one image is taken under other settings than the strategy chose

A session has at most one such image, named as people write it and as settings_words/3 shows settings:

    i3: left 7 right 0 top 0, 1/60 s, f/4

Lights that are not named are off.
*/

:- autoload(device, [device_lights/2]).
:- autoload(library(apply), [maplist/3]).
:- autoload(library(dcg/basics), [blanks/2, integer/3, number/3, remainder/3, string_without/4]).
:- use_module(library(lists), [member/2, memberchk/2]).
:- autoload(library(pairs), [pairs_keys/2]).

:- dynamic
    wanted/1.                           % Words

%!  set_instead(+Words) is det.
%
%   From now on; `none` for no such image.

set_instead(Words) :-
    retractall(wanted(_)),
    (   Words == none
    ->  true
    ;   assertz(wanted(Words))
    ).

%!  instead(+Taken, +Device, -Settings) is semidet.
%
%   The settings of the next image after Taken, where it is the one that is taken under others.

instead(Taken, Device, Settings) :-
    wanted(Words),
    parsed(Words, Number, Parts),
    Taken =:= Number - 1,
    settings_of(Parts, Device, Settings).

%!  instead_image(+Words, -Number) is semidet.
%
%   The number of the image that these words are about; false where they are no settings of an image.

instead_image(Words, Number) :-
    parsed(Words, Number, _).

%!  instead_lights(+Words, -Names) is semidet.
%
%   The lights that these words name, whether or not they say all that an image needs.

instead_lights(Words, Names) :-
    atom_codes(Words, Codes),
    once(phrase(( numbered(_), lights(Pairs), remainder(_) ), Codes)),
    pairs_keys(Pairs, Names).

%!  instead_settings(+Words, +Device, -Settings) is semidet.
%
%   What these words say of this device, whether or not it offers it; false where they are no settings or name a light
%   that is not there.

instead_settings(Words, Device, Settings) :-
    parsed(Words, _, Parts),
    settings_of(Parts, Device, Settings).

settings_of(parts(Pairs, Shutter, Aperture), Device, settings(Levels, Shutter, Aperture)) :-
    device_lights(Device, Lights),
    forall(member(Name-_, Pairs), memberchk(light(Name, _), Lights)),
    maplist(level_of(Pairs), Lights, Levels).

level_of(Pairs, light(Name, _), Level) :-
    ( memberchk(Name-Given, Pairs) -> Level = Given ; Level = 0 ).

parsed(Words, Number, Parts) :-
    atom_codes(Words, Codes),
    phrase(image(Number, Parts), Codes).

image(Number, parts(Lights, Shutter, Aperture)) -->
    numbered(Number), lights(Lights), comma(Lights), blanks,
    shutter(Shutter), blanks, "s", blanks, ",", blanks,
    "f/", number(Aperture), blanks.

numbered(Number) -->
    blanks, "i", integer(Number), blanks, ":", blanks.

lights([Name-Level|Lights]) -->
    string_without(`, `, Codes), { Codes = [_|_], atom_codes(Name, Codes) },
    blanks, integer(Level), blanks,
    lights(Lights).
lights([]) --> [].

comma(_) --> ",".
comma([]) --> [].                       % where none is named

shutter(Seconds) -->
    "1/", number(Part), { Part > 0, Seconds is 1 / Part }.
shutter(Seconds) -->
    number(Seconds).
