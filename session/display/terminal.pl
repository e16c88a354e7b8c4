:- module(session_terminal,
          [ can_be_drawn_on/0,
            terminal_width/1,           % -Columns
            draw_below/1,               % +Lines
            clear_below/0
          ]).
/** <module> The terminal of a session, and what is drawn anew below its lines

What is drawn below stays the last thing on the terminal: it is cleared before each message, and stands lower the next
time that it is drawn.  It has no line that is as wide as the terminal, so that it can be cleared by going up.
*/

:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [last/2, member/2]).

:- dynamic
    drawn/2.                            % Width, Lines: what stands below now

%!  can_be_drawn_on is semidet.
%
%   Standard error is a terminal that can move its cursor.

can_be_drawn_on :-
    stream_property(user_error, tty(true)),
    \+ ( getenv('TERM', Term), memberchk(Term, ['', dumb, unknown]) ).

%!  terminal_width(-Columns) is det.

terminal_width(Width) :-
    catch(tty_size(_, Width), error(_, _), fail),
    Width >= 40,
    !.
terminal_width(80).

%!  draw_below(+Lines) is det.
%
%   Each line is given in several lengths, the longest first: time goes on at its end, so that it is not cut where a
%   shorter one fits.  The same lines are not drawn twice.

draw_below(Lines) :-
    terminal_width(Width),
    (   drawn(Width, Lines)
    ->  true
    ;   clear_below,
        Room is Width - 1,
        maplist(fitting(Room), Lines, Cut),
        atomic_list_concat(Cut, '\r\n', Text),
        write(user_error, Text),
        flush_output(user_error),
        assertz(drawn(Width, Lines))
    ).

fitting(Room, Texts, Text) :-
    (   member(Text, Texts),
        string_length(Text, Length),
        Length =< Room
    ->  true
    ;   last(Texts, Shortest),
        cut(Room, Shortest, Text)
    ).

cut(Room, Line, Cut) :-
    (   sub_atom(Line, 0, Room, After, Begin),
        After > 0
    ->  Cut = Begin
    ;   Cut = Line
    ).

%!  clear_below is det.

clear_below :-
    retract(drawn(_, Lines)),
    !,
    length(Lines, Count),
    Up is Count - 1,
    ( Up > 0 -> format(user_error, "\r\e[~dA\e[J", [Up]) ; write(user_error, '\r\e[J') ),
    write(user_error, '\r'),           % the stream counts codes as columns: a message would begin with an empty line
    flush_output(user_error).
clear_below.
