% `informed` without prediction line by line: settings are chosen by search over qualitative states, as `heuristic` does.

proc(choose_next, if(doubted, choose_telling, choose_promising)).

:- include('../../domain/controllers/informed.pl').
