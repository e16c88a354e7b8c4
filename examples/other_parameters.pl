% What the images at hand can be made to tell costs no image: where the pose is not trusted, they are measured again with
% other parameters of the vision server, the likeliest remedy first, and what makes the pose surer stays.
%
%   swipl main.pl --controller examples/other_parameters.pl --scenario harsh --threshold 0.02 --explain

proc(control,
     [ choose_safe, take_image, judge,
       while(neg(or([and(converged, confirmed), exhausted, spent])),
             [choose_informative, take_image, judge]) ]).

proc(judge,
     [ measure,
       remedy(refinement_scale_px, 4.0, 1.0),           % edges are soft: blur, rounded corners
       remedy(edge_contrast_grey, 4.0, 0.0),            % texture or noise is taken for edges
       if(harmless, keep_image, [mark_unfavourable, drop_image('the pose got worse')]) ]).

% Value is tried in the place of the usual one; where the pose is trusted already, or this is tried already, nothing is.
proc(remedy(Parameter, Value, Usual),
     if(or(trusted_with_it, parameter(Parameter) = Value),
        [],
        pi(px, [ ?(merit(fix, px)),
                 set_parameter(Parameter, Value), measure,
                 if(improves(fix, px), [], [set_parameter(Parameter, Usual), measure]) ]))).

proc(trusted_with_it, some(px, and(merit(fix, px), px < threshold))).
