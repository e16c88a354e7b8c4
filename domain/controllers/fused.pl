% A fixed bracket: all lights full, every shutter, and the exposures fused into one image before edges are looked for.

proc(control,
     [ set_parameter(fusion, true),
       pi(bracket, [?(bracket(device, bracket)), take_each(bracket)]) ]).

proc(take_each([]), []).
proc(take_each([S|Rest]),
     if(exhausted, [], [choose(S), take_image, measure, keep_image, take_each(Rest)])).
