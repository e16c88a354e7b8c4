% `informed` without test images: what is doubted is left so.

proc(choose_next, choose_informative).
proc(enough, or(and(converged, confirmed), spent)).

:- include('../../domain/controllers/informed.pl').
