% A docking approach: come closer by hold points; at each, fix the pose from the
% last one as seed and go on only when it can be trusted.  Uses the strategy's
% `control` at each hold point.

proc(approach(Ranges), approach_(Ranges)).

proc(approach_([]), []).
proc(approach_([R|Rs]),
     [ advance(R), control,
       if(converged,
          [hold_done(fixed), approach_(Rs)],
          [retake,
           if(converged, [hold_done(fixed), approach_(Rs)], hold_done(aborted))]) ]).
