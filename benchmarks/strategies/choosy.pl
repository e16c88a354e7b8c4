% `informed` that keeps an image only if the pose got better with it, as `heuristic` does once there is a pose.

proc(judge,
     [ measure,
       if(or(worth_keeping, and([converged, neg(confirmed), harmless])),
          keep_image,
          [mark_unfavourable, drop_image('adds too little')]) ]).

:- include('../../domain/controllers/informed.pl').
