% One image under each light alone, exposed for what has been learnt so far, until
% the pose can be trusted.
%
%   swipl main.pl --controller examples/one_light_at_a_time.pl

proc(control,
     pi(lights, [?(light_count(device, lights)), light_up_to(1, lights)])).

proc(light_up_to(N, Count),
     if(or(finished, N > Count),
        [],
        [ pi(s, [?(alone_well_exposed(N, s)), choose(s)]),
          take_image, measure,
          if(worth_keeping, keep_image, drop_image('adds too little')),
          light_up_to(M, Count) ])) :-
    integer(N), M is N + 1.

proc(alone_well_exposed(N, S),
     and(only_light(device, N, Levels), best_exposure(device, readings, Levels, S))).
