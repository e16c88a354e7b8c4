% `lasting` whose settings are drawn at random after the first, safe image.

proc(choose_next, choose_random).
proc(enough, false).

:- include('../../domain/controllers/informed.pl').
