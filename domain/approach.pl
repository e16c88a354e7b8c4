% A docking approach: come closer by hold points.  At each the strategy's `control`
% fixes the pose, with the last one as seed; the next step is taken only when the
% merit allows.  Otherwise images are taken afresh, once, and then the approach is
% aborted.

proc(session(Ranges), [connect, approach(Ranges)]).

proc(approach([Contact]), [advance(Contact), fix_pose, if(converged, hold_done(reached), hold_done(aborted))]).
proc(approach([Range, Next|Ranges]),
     [ advance(Range), fix_pose,
       if(converged,
          [hold_done(fixed), approach([Next|Ranges])],
          hold_done(aborted)) ]).

proc(fix_pose, [control, if(converged, [], [start_over, control])]).
