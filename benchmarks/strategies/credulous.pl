% `informed` that believes one image alone.

proc(enough, and(neg(doubted), or(converged, spent))).

:- include('../../domain/controllers/informed.pl').
