:- module(session_wrapping,
          [ wrapped/3                   % +Stream, +Lines, -Wrapped
          ]).
/** <module> Lines of messages, broken between words where a terminal is too narrow for them */

:- use_module(terminal, [clear_below/0, terminal_width/1]).
:- use_module(library(apply), [foldl/4]).
:- use_module(library(lists), [append/3, member/2, memberchk/2, reverse/2]).
:- use_module(library(pairs), [pairs_keys/2]).

hanging(5).                             % columns by which a broken line goes on further in than it began
prefixed(9).                            % columns of "Warning: "

:- multifile user:message_hook/3.

user:message_hook(_, Kind, [_|_]) :-
    Kind \== silent,
    clear_below,
    fail.
user:message_hook(_, Kind, Lines) :-
    memberchk(Kind-Room, [help-0, error-Prefixed, warning-Prefixed]),
    prefixed(Prefixed),
    wrapped(user_error, Room, Lines, Wrapped),
    Wrapped \== Lines,
    print_message_lines(user_error, kind(Kind), Wrapped).

%!  wrapped(+Stream, +Lines, -Wrapped) is det.
%
%   Lines as of print_message_lines/3.  They stay as they are where Stream is no terminal, where they fit, and where
%   there is more in them than words and their colours.

wrapped(Stream, Lines, Wrapped) :-
    wrapped(Stream, 0, Lines, Wrapped).

wrapped(Stream, Room, Lines, Wrapped) :-
    stream_property(Stream, tty(true)),
    terminal_width(All),
    Width is All - Room,
    foldl(cells, Lines, [[]], Newest),  % each line backwards
    member(Line, Newest),
    length(Line, Length),
    Length > Width,
    !,
    reverse(Newest, Oldest),
    foldl(broken(Width), Oldest, [], Reversed),
    reverse(Reversed, [nl|Wrapped]).
wrapped(_, _, Lines, Lines).

                /*******************************
                *   LINES AS LISTS OF CELLS    *
                *******************************/

%   A cell is Char-Attributes.
cells(nl, Lines, [[]|Lines]) :-
    !.
cells(Element, [Line0|Lines], [Line|Lines]) :-
    element(Element, Attributes, Format, Arguments),
    length(Line0, Column),
    atom_concat('~*c', Format, AfterBlanks),        % column stops are those of the line
    format(chars(Chars), AfterBlanks, [Column, 0' |Arguments]),
    length(Blanks, Column),
    append(Blanks, New, Chars),
    foldl(cell(Attributes), New, Line0, Line).

cell(Attributes, Char, Line, [Char-Attributes|Line]).

element(ansi(Attributes, Format, Arguments), Attributes, Format, Arguments) :-
    !.
element(Format-Arguments, [], Format, Arguments) :-
    is_list(Arguments),
    !.
element(Format, [], Format, []) :-
    atomic(Format).

%   The elements of a line, newest first, before those of the lines that come after it.
broken(Width, Backwards, Elements0, Elements) :-
    reverse(Backwards, Line),
    words(Line, Words),
    (   Words = [word(Lead, _, _)|_]
    ->  hanging(More),
        Indent is Lead + More,
        foldl(placed(Width, Indent), Words, at(0, [nl|Elements0]), at(_, Elements))
    ;   Elements = [nl|Elements0]
    ).

%   Words are word(BlanksBefore, Cells, Length).
words(Line, Words) :-
    span(blank, Line, Blanks, Rest),
    span(shown, Rest, Cells, Others),
    (   Cells == []
    ->  Words = []
    ;   length(Blanks, Before),
        length(Cells, Length),
        Words = [word(Before, Cells, Length)|More],
        words(Others, More)
    ).

span(Class, [Cell|Cells], [Cell|Spanned], Rest) :-
    call(Class, Cell),
    !,
    span(Class, Cells, Spanned, Rest).
span(_, Rest, [], Rest).

blank(' '-_).

shown(Char-_) :-
    Char \== ' '.

placed(Width, Indent, word(Blanks, Cells, Length), at(Column, Elements0), at(Next, Elements)) :-
    (   Column + Blanks + Length =< Width
    ->  Gap = Blanks,
        Elements1 = Elements0,
        Next is Column + Blanks + Length
    ;   Gap = Indent,
        Elements1 = [nl|Elements0],
        Next is Indent + Length
    ),
    pairs_keys(Cells, Chars),
    atomic_list_concat(Chars, Text),
    ( Cells = [_-Attributes|_], Attributes \== [] -> Word = ansi(Attributes, '~w', [Text]) ; Word = '~w'-[Text] ),
    Elements = [Word, '~*c'-[Gap, 0' ]|Elements1].
