% Light where it matters: each image is taken under the settings that are predicted, line by line, to add most to
% the pose.  What they added is its part of the evidence and kept, unless the pose got worse with it.  One image
% alone does not end it.  Where an image is not as foreseen and it is not sure why, the next one is taken to tell;
% a target that is seen to have moved (`surprise`) is another pose: the set begins anew.

proc(control,
     [ choose_first, take_image, judge,
       while(neg(or(exhausted, enough)), [choose_next, take_image, judge]) ]).

proc(choose_first, choose_safe).
proc(choose_next, if(doubted, choose_telling, choose_informative)).
proc(enough, and(neg(doubted), or(and(converged, confirmed), spent))).

proc(judge,
     [ measure,
       if(harmless,
          keep_image,
          [mark_unfavourable, drop_image('the pose got worse')]) ]).
