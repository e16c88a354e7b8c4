% `informed` without a safe first image: it is drawn at random, as that of `heuristic`.

proc(control,
     [ choose_random, take_image, judge,
       while(and(neg(exhausted), or(doubted, neg(or(and(converged, confirmed), spent)))),
             [if(doubted, choose_telling, choose_informative), take_image, judge]) ]).

proc(judge,
     [ measure,
       if(harmless,
          keep_image,
          [mark_unfavourable, drop_image('the pose got worse')]) ]).
