% Exposure bracketing: all lights at the exposure that suits the target, once more when the first image has shown how
% bright it is, and then under every other shutter, until the pose can be trusted.
%
%   swipl main.pl --controller examples/bracket.pl

proc(control,
     [ metered, metered,
       pi(shutters, [?(other_shutters(device, settings, shutters)), under_each(shutters)]) ]).

proc(metered,
     if(finished, [], [pi(s, [?(well_exposed(s)), choose(s)]), take_image, judge])).

proc(under_each([]), []).
proc(under_each([Shutter|Others]),
     if(finished,
        [],
        [ pi(s, [?(with_shutter(settings, Shutter, s)), choose(s)]),
          take_image, judge,
          under_each(Others) ])).

proc(judge, [measure, if(worth_keeping, keep_image, drop_image('adds too little'))]).

% Plain Prolog, called in tests with the fluents replaced by their values.

other_shutters(Device, settings(_, Used, _), Others) :-
    device_shutters(Device, Shutters),
    exclude(==(Used), Shutters, Others).

with_shutter(settings(Levels, _, Aperture), Shutter, settings(Levels, Shutter, Aperture)).
