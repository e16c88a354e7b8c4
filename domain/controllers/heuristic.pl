% The paper's controller: random first settings, then greedy heuristic search over
% qualitative states.  Once there is a pose, an image that does not improve the merit
% enough is dropped and its state marked unfavourable.  One image alone does not end it: the second may be one
% that bears out a trusted pose.  No more are taken when they would hardly help.

proc(control,
     [ choose_random, take_image, judge,
       while(neg(or([and(converged, confirmed), exhausted, spent])),
             [choose_promising, take_image, judge]) ]).

proc(judge,
     [ measure,
       if(or(worth_keeping, and([converged, neg(confirmed), harmless])),
          keep_image,
          [mark_unfavourable, drop_image('adds too little')]) ]).
