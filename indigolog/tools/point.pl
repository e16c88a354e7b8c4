:- module(indigolog_point, []).
/** <module> Where in a program an error was met

Found when an error has happened, by looking which part of the program meets the same
error again, so that nothing need be remembered while all is well.
*/

:- use_module('../language/action', [pick/5]).
:- use_module('../language/context', [top_context/1]).
:- use_module('../language/formula', [holds_in/2]).
:- use_module('../language/binding', [bound_variables/2]).
:- use_module('../language/semantics', [final/3, program_part/2, trans/5]).
:- use_module('../language/situation', [situation_module/2]).

% What looking for the place may cost.
most_inferences(1_000_000).

:- multifile indigolog_semantics:error_place/5.

%!  indigolog_semantics:error_place(+Formal, +Program, +Situation, -Point, -Bindings) is det.
%
%   Point is the innermost part of Program of which a step in Situation meets an
%   error whose formal term is Formal.  Bindings are Name=Value of the choices of
%   arguments around it, and call(Procedure), outermost first.

indigolog_semantics:error_place(Formal, E, S, Point, Bindings) :-
    most_inferences(Most),
    (   catch(call_with_inference_limit(innermost(Formal, E, S, Point0, Bindings0), Most, Result), _, fail),
        Result \== inference_limit_exceeded
    ->  Point = Point0, Bindings = Bindings0
    ;   Point = E, Bindings = []
    ).

innermost(Formal, E, S, Point, Bindings) :-
    (   part(E, S, Part, Own),
        meets(Formal, Part, S)
    ->  innermost(Formal, Part, S, Point, Inner),
        append_bindings(Own, Inner, Bindings)
    ;   Point = E, Bindings = []
    ).

append_bindings([], Bs, Bs).
append_bindings([B|As], Bs, [B|Cs]) :-
    append_bindings(As, Bs, Cs).

meets(Formal, E, S) :-
    top_context(C),
    catch(( trans(E, S, C, _, _), fail ), error(Met, _), true),
    nonvar(Met),
    \+ Met \= Formal.

% part(+Program, +Situation, -Part, -Bindings): Part may make the next step.
part(E, _, _, _), var(E) =>
    fail.
part([E|L], S, Part, Bindings) =>
    Bindings = [],
    (   Part = E
    ;   top_context(C),
        final(E, S, C),
        Part = L
    ).
part(if(P, E, F), S, Part, Bindings) =>
    Bindings = [],
    (   holds_in(P, S) -> Part = E ; Part = F ).
part(E, S, Part, Bindings), picks(E, V, Body) =>
    bound_variables(V, Names),
    pick(V, Names-Body, ordered, S, Values-Part),
    paired(Names, Values, Bindings).
part(E, S, Part, Bindings) =>
    (   program_part(E, Part),
        Bindings = []
    ;   situation_module(S, Module),
        Module:proc(E, Part)
    ->  Bindings = [call(E)]
    ).

picks(pi(V, E), V, E).
picks(pi(V, D, E), (V, D), E).
picks(rpi(V, E), V, E).
picks(rpi(V, D, E), (V, D), E).
picks(interrupt(V, P, E), V, if(P, E, ?(false))).

paired([], [], []).
paired([N|Ns], [V|Vs], [N=V|Bs]) :-
    paired(Ns, Vs, Bs).
