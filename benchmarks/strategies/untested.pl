% `informed` without test images: what is doubted is left so.

proc(control,
     [ choose_safe, take_image, judge,
       while(neg(or([exhausted, and(converged, confirmed), spent])),
             [choose_informative, take_image, judge]) ]).

proc(judge,
     [ measure,
       if(harmless,
          keep_image,
          [mark_unfavourable, drop_image('the pose got worse')]) ]).
