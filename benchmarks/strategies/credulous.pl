% `informed` that believes one image alone.

proc(control,
     [ choose_safe, take_image, judge,
       while(and(neg(exhausted), or(doubted, neg(or(converged, spent)))),
             [if(doubted, choose_telling, choose_informative), take_image, judge]) ]).

proc(judge,
     [ measure,
       if(harmless,
          keep_image,
          [mark_unfavourable, drop_image('the pose got worse')]) ]).
