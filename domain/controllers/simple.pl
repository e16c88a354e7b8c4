% The paper's first rival: random settings, every image kept.

proc(control,
     while(neg(finished),
           [choose_random, take_image, measure, keep_image])).
