% A camera with an exposure program: all lights full, shutter and aperture metered
% until the target's highlights are near 0.8 of full scale; one image is used.

proc(control,
     [choose_reference, take_image, meter(5), measure, keep_image]).

proc(meter(0), []).
proc(meter(N),
     pi(s, [ ?(well_exposed(s)),
             if(or(settings = s, exhausted),
                [],
                [drop_image(metering), choose(s), take_image, meter(M)]) ])) :-
    integer(N), N > 0, M is N - 1.
