% `informed` that takes all images it may, trusted or not, and none to test what is doubted.

proc(choose_next, choose_informative).
proc(enough, false).

:- include('../../domain/controllers/informed.pl').
