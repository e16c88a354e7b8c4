% A pose is believed when the newest image alone shows it, too: one that only holds together because all of its images
% share an error is found out. Where the two differ, more images are taken until they agree or no more may be taken.
%
%   swipl main.pl --controller examples/second_opinion.pl

proc(control,
     while(neg(or(exhausted, agreed)),
           [ choose_promising, take_image, measure,
             if(worth_keeping,
                [keep_image, if(and(converged, confirmed), measure_the_newest)],
                [mark_unfavourable, drop_image('adds too little')]) ])).

% Any images that were kept can be measured; what is believed (best) changes only when one is kept.
proc(measure_the_newest, pi(images, [?(newest(image_set, images)), estimate(images)])).

proc(agreed, and([converged, confirmed, same_pose(best, fix)])).

% Plain Prolog: the newest image of a set; poses nearer to each other than a hundredth of the range.

newest([kept(Image, _)|_], [Image]).

same_pose(fix(pose(_, [X1, Y1, Z1]), _, _, _), fix(pose(_, [X2, Y2, Z2]), _, _, _)) :-
    sqrt((X1 - X2) ** 2 + (Y1 - Y2) ** 2 + (Z1 - Z2) ** 2) =< 0.01 * Z1.
