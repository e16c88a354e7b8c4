% The paper's second rival: random settings; the last image is dropped when the
% error did not fall.

proc(control,
     while(neg(finished),
           [ choose_random, take_image, measure,
             if(improved, keep_image, drop_image('the error did not fall')) ])).
