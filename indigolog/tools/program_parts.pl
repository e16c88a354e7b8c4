:- module(indigolog_program_parts,
          [ part_within/3             % +Program, ?Part, -Around
          ]).
/** <module> The parts of a program, at any depth */

:- use_module('../language/semantics', [construct/2, program_part/2]).

%!  part_within(+Program, ?Part, -Around) is nondet.
%
%   Part is Program or a part of it at any depth, outermost and leftmost first, and no variable.  Around are the
%   constructs and calls that it stands in, innermost first: a procedure may be given a program.

part_within(Program, Part, Around) :-
    part_within(Program, Part, [], Around).

part_within(E, Part, Around, Around) :-
    nonvar(E),
    Part = E.
part_within(E, Part, Around0, Around) :-
    nonvar(E),
    (   construct(E, _)
    ->  program_part(E, E1)
    ;   compound(E),
        arg(_, E, E1)
    ),
    part_within(E1, Part, [E|Around0], Around).
