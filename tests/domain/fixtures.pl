:- module(domain_fixtures,
          [ testbed/1,                  % -Device
            ring/1                      % -Device
          ]).

/** <module> Devices that the domain's tests speak of */

%!  testbed(-Device) is det.
%
%   The paper's: three lights of eight levels, five shutters, three apertures.

testbed(device([light(left, 8), light(right, 8), light(top, 8)],
               [0.0041667, 0.0083333, 0.0166667, 0.0333333, 0.0666667],
               [2.8, 4.0, 5.6],
               sensor(2.0, 6.0, 10000.0, 1.0),
               exposure(0.0166667, 4.0),
               0.001)).

%!  ring(-Device) is det.
%
%   Twelve lights that can only be on or off, one that is always on, one exposure.

ring(device(Lights, [0.01], [8.0], sensor(1.0, 2.0, 10000.0, 1.0), exposure(0.01, 8.0), 0.001)) :-
    findall(light(Name, 2), ( between(1, 12, I), atom_concat(l, I, Name) ), Ring),
    append(Ring, [light(lamp, 1)], Lights).
