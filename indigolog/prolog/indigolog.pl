:- module(indigolog_pack, []).
/** <module> library(indigolog) of the pack: the interpreter */

:- reexport('../indigolog').

