:- module(domain_fixtures,
          [ ring/1                      % -Device
          ]).
/** <module> Devices that the domain's tests speak of */

:- reexport('../../domain/testing/simulated_world', [testbed/1]).

%!  ring(-Device) is det.
%
%   Twelve lights that can only be on or off, one that is always on, one exposure.

ring(device(Lights, [0.01], [8.0], sensor(1.0, 2.0, 10000.0, 1.0), exposure(0.01, 8.0), 0.001)) :-
    findall(light(Name, 2), ( between(1, 12, I), atom_concat(l, I, Name) ), Ring),
    append(Ring, [light(lamp, 1)], Lights).
