% `informed` without a safe first image: it is drawn at random, as that of `heuristic`.

proc(choose_first, choose_random).

:- include('../../domain/controllers/informed.pl').
