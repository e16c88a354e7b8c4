% `lasting` without prediction line by line: settings are chosen by search over qualitative states, as `heuristic` does.

proc(choose_next, choose_promising).
proc(enough, false).

:- include('../../domain/controllers/informed.pl').
