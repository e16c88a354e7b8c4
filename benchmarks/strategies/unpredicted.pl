% `informed` without prediction line by line: settings are chosen by search over qualitative states, as `heuristic` does.

proc(control,
     [ choose_safe, take_image, judge,
       while(and(neg(exhausted), or(doubted, neg(or(and(converged, confirmed), spent)))),
             [if(doubted, choose_telling, choose_promising), take_image, judge]) ]).

proc(judge,
     [ measure,
       if(harmless,
          keep_image,
          [mark_unfavourable, drop_image('the pose got worse')]) ]).
