% `informed` that keeps an image only if the pose got better with it, as `heuristic` does once there is a pose.

proc(control,
     [ choose_safe, take_image, judge,
       while(and(neg(exhausted), or(doubted, neg(or(and(converged, confirmed), spent)))),
             [if(doubted, choose_telling, choose_informative), take_image, judge]) ]).

proc(judge,
     [ measure,
       if(or(worth_keeping, and([converged, neg(confirmed), harmless])),
          keep_image,
          [mark_unfavourable, drop_image('adds too little')]) ]).
