% Exposure driven by gradients (Shim et al. 2014), lights before shutter: light is added or taken away until the
% image's gradients are richest as it is, or it would be light that was tried; one image is used.

proc(control,
     [choose_reference, take_image, enrich(7), measure, keep_image]).

proc(enrich(0), []).
proc(enrich(N),
     [ pi(i, [?(candidate = i), appraise(i)]),
       pi(s, [ ?(richer(s)),
               if(or(member(s, tried), exhausted),
                  [],
                  [ drop_image(metering), choose(s), take_image, enrich(M) ]) ]) ]) :-
    integer(N), N > 0, M is N - 1.
