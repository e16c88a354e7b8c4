:- module(indigolog_pack, []).
:- reexport('../indigolog').

/** <module> library(indigolog) of the pack: the interpreter */
