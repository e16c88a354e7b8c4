% A strategy as rules, the most urgent first: after each action, and after whatever happened meanwhile, the first rule
% that applies says what to do next. When the sun changes the images of the old light are gone, and the rules go on.
%
%   swipl main.pl --scenario turning-sun --controller examples/rules.pl

proc(control,
     prioritized_interrupts(
         [ interrupt(unmeasured, measure),
           interrupt(neg(candidate = none), if(worth_keeping, keep_image, drop_image('adds too little'))),
           interrupt(neg(or(exhausted, and(converged, confirmed))), [choose_promising, take_image]) ])).

proc(unmeasured, and(neg(candidate = none), neg(member(candidate, measured)))).
