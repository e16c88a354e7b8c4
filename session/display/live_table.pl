:- module(session_live_table,
          [ begin_table/2,              % +Options, +Plan
            end_table/0,
            table_is_live/0,
            note_action/2,              % +Action, +Situation
            pulse/2,                    % +Op, +Seconds
            table_head//1,              % +Device
            table_row//2                % +Device, +Step
          ]).
/** <module> A session as a table in the terminal, while it runs

A row for each image that was judged.  Below them is what is being done now, how far the session is, and how long it
may take, drawn anew as time goes.  Only on a terminal: what goes into a file or a pipe is lines.
*/

:- use_module(outcome, [merit_words/2]).
:- use_module(terminal).
:- use_module('../../domain/reasoning/device').
:- use_module('../../domain/reasoning/merit').
:- use_module('../../domain/reasoning/qualitative').
:- use_module('../../indigolog/indigolog', [fluent_value/3]).
:- use_module(library(apply), [foldl/4, maplist/3, maplist/4]).
:- use_module(library(lists), [member/2, sum_list/2]).
:- use_module(library(option), [option/2]).
:- use_module(library(yall)).

:- dynamic
    live/1,                             % Limit on images, or holds(N)
    since/2,                            % When, Count: servers are waited for since then, and what was done before
    done/2,                             % Count, When: images judged or hold points left behind, and when the last was
    state/2,                            % words on where the session stands, and on its merit
    under_way/2.                        % words on the next image: its name, and name and settings

%!  begin_table(+Options, +Plan) is det.

begin_table(Options, Plan) :-
    end_table,
    (   can_be_drawn_on,
        \+ option(quiet(true), Options)
    ->  ( Plan.program = session(Ranges) -> length(Ranges, Holds), Limit = holds(Holds)
        ; option(max_iterations(Limit), Options) ),
        get_time(Now),
        assertz(live(Limit)),
        assertz(done(0, Now))
    ;   true
    ).

%!  end_table is det.

end_table :-
    clear_below,
    forall(member(Fact, [live(_), since(_, _), done(_, _), state(_, _), under_way(_, _)]), retractall(Fact)).

%!  table_is_live is semidet.

table_is_live :-
    live(_).

                /*******************************
                *             ROWS             *
                *******************************/

lights_room(24).                        % columns for all lights; where their names need more, only levels are shown
fixed_room(45).                         % for all columns but lights and state, blanks between them, and the margin

%!  table_head(+Device)// is det.

table_head(Device) -->
    { lights_cells(Device, names, Lights),
      row([image, Lights, shutter, 'f/', 'looks, stops', decision, merit, set], Device, Left, State, Decision, Right) },
    [ ansi(bold, '~w~w~w~w', [Left, State, Decision, Right]) ].

%!  table_row(+Device, +Step)// is det.

table_row(Device, step(_, Image, Settings, Looks, Decision, Reason, SetSize, Fix, _)) -->
    { settings_cells(Device, Settings, Lights, Shutter, Aperture),
      state_words(Looks, LooksWords),
      without_unit(LooksWords, Short),
      merit_cell(Fix, Merit),
      row([Image, Lights, Shutter, Aperture, Short, Decision, Merit, SetSize], Device,
          Left, State, DecisionCell, Right),
      decision_colour(Decision, Colour) },
    [ '~w~w'-[Left, State], ansi(fg(Colour), '~w', [DecisionCell]), '~w'-[Right] ],
    because(Reason).

because('') --> !.
because(Reason) -->
    [ nl, ansi(faint, '       ~w', [Reason]) ].

decision_colour(keep, green).
decision_colour(discard, red).

merit_cell(none, 'no pose') :-
    !.
merit_cell(Fix, Cell) :-
    merit(Fix, Merit),
    merit_words(Merit, Cell).

without_unit(Words, Short) :-
    member(Unit, [" stops", " stop"]),
    string_concat(Short, Unit, Words),
    !.
without_unit(Words, Words).

%   The parts of a line, each as wide as its column; Decision is apart since it has a colour.
row([Image, Lights, Shutter, Aperture, Looks, Decision0, Merit, Set], Device, Left, State, Decision, Right) :-
    left_part(Image, Lights, Shutter, Aperture, Left),
    lights_width(Device, LightsWidth),
    terminal_width(Width),
    fixed_room(Fixed),
    widest_state(Device, Most),
    Room is min(Most, Width - Fixed - LightsWidth),
    (   Room >= 8
    ->  padded(Looks, Room, Padded),
        string_concat(Padded, " ", State)
    ;   State = ""                      % what there is no room for is left out
    ),
    format(string(Decision), "~w~t~8|", [Decision0]),
    format(string(Right), "~t~w~8|~t~w~4+", [Merit, Set]).

%   Columns for a state in words: 22, or as many as `medium from LIGHT, -1` takes.
widest_state(Device, Width) :-
    device_lights(Device, Lights),
    foldl([light(Name, _), W0, W]>>( atom_length(Name, L), W is max(W0, 16 + L) ), Lights, 22, Width).

left_part(Image, Lights, Shutter, Aperture, Left) :-
    maplist(padded, [Image, Shutter, Aperture], [5, 7, 4], [ImageCell, ShutterCell, ApertureCell]),
    atomic_list_concat(['', ImageCell, Lights, '', ShutterCell, ApertureCell, ''], ' ', Left).

padded(Text, Width, Padded) :-
    ( sub_string(Text, 0, Width, _, Cut) -> true ; Cut = Text ),
    format(string(Padded), "~w~t~*|", [Cut, Width]).

settings_cells(Device, settings(Levels, Shutter, Aperture), Lights, ShutterWords, Aperture) :-
    lights_cells(Device, levels(Levels), Lights),
    shutter_words(Shutter, ShutterWords).

%   A column for each light where their names fit, and one for all of them where not.
lights_cells(Device, What, Cells) :-
    device_lights(Device, Lights),
    lights_width(Device, All),
    (   named_widths(Lights, Widths)
    ->  ( What = levels(Levels) -> true ; maplist([light(Name, _), Name]>>true, Lights, Levels) ),
        maplist([Level, Width, Cell]>>format(atom(Cell), "~t~w~*|", [Level, Width]), Levels, Widths, Parts),
        atomic_list_concat(Parts, ' ', Text)
    ;   What = levels(Levels)
    ->  atomic_list_concat(Levels, ' ', Spaced),
        atom_length(Spaced, Length),
        ( Length =< All -> Text = Spaced ; atomic_list_concat(Levels, Text) )
    ;   Text = lights
    ),
    padded(Text, All, Cells).

lights_width(Device, Width) :-
    device_lights(Device, Lights),
    (   named_widths(Lights, Widths)
    ->  sum_list(Widths, Sum),
        length(Widths, Count),
        Width is max(0, Sum + Count - 1)
    ;   lights_room(Width)
    ).

named_widths(Lights, Widths) :-
    maplist([light(Name, _), Width]>>( atom_length(Name, Length), Width is max(2, Length) ), Lights, Widths),
    sum_list(Widths, Sum),
    length(Widths, Count),
    lights_room(Most),
    Sum + Count - 1 =< Most.

                /*******************************
                *        WHAT IS BELOW         *
                *******************************/

%!  note_action(+Action, +Situation) is det.
%
%   Where the session stands after an action.

note_action(_, _) :-
    \+ live(_),
    !.
note_action(choose(Settings), S) :-
    !,
    fluent_value(device, S, Device),
    fluent_value(iteration, S, Taken),
    Next is Taken + 1,
    format(atom(Image), "i~d", [Next]),
    settings_cells(Device, Settings, Lights, Shutter, Aperture),
    left_part(Image, Lights, Shutter, Aperture, Words),
    format(string(Name), " ~w ", [Image]),
    retractall(under_way(_, _)),
    assertz(under_way(Name, Words)).
note_action(Action, S) :-
    judged(Action),
    !,
    retractall(under_way(_, _)),
    note_state(S).
note_action(_, _).

judged(keep(_)).
judged(discard(_, _)).
judged(hold_done(_)).

note_state(S) :-
    live(Limit),
    get_time(Now),
    fluent_value(merit, S, Merit),
    fluent_value(threshold, S, Threshold),
    fluent_value(holds, S, Holds),
    fluent_value(taken, S, Taken),
    (   Limit = holds(All)
    ->  length(Holds, Done),
        At is min(All, Done + 1),
        format(string(Place), "hold point ~d of ~d", [At, All])
    ;   Done = Taken,
        format(string(Place), "~d of at most ~d images", [Taken, Limit])
    ),
    ( done(Done, _) -> true ; retractall(done(_, _)), assertz(done(Done, Now)) ),
    maplist(merit_words, [Merit, Threshold], [Has, Wanted]),
    format(string(Reached), "merit ~w px (~w wanted)", [Has, Wanted]),
    retractall(state(_, _)),
    assertz(state(Place, Reached)).

%!  pulse(+Op, +Seconds) is det.
%
%   An answer to Op has been waited for, for so long.

pulse(Op, Seconds) :-
    live(_),
    !,
    ( since(_, _) -> true ; with_images(Op) -> begin_count ; true ),
    waiting_words(Op, Seconds, Waiting),
    ( under_way(Name, Image) -> true ; Name = " ", Image = " " ),
    findall(Text, ( member(Before, [Image, Name, " "]), string_concat(Before, Waiting, Text) ), Doings),
    times(Times),
    ( state(Place, Reached) -> Standings = [[Place, Reached|Times], [Place|Times], Times] ; Standings = [Times] ),
    findall(Line, ( member(Parts, Standings), atomic_list_concat(Parts, ', ', Text), string_concat(" ", Text, Line) ), Lines),
    draw_below([Doings, Lines]).
pulse(_, _).

%   What is done again when a session goes on takes no time, and tells nothing of what is to come.
begin_count :-
    get_time(Now),
    done(Count, _),
    assertz(since(Now, Count)).

with_images(capture).
with_images(estimate).
with_images(predict).

patience_s(1).                          % after which it is said what is waited for; chosen by hand

waiting_words(Op, Seconds, Words) :-
    doing(Op, Doing, For),
    patience_s(Patience),
    (   Seconds < Patience
    ->  Words = Doing
    ;   format(string(Words), "waiting for ~w, ~0f s", [For, Seconds])
    ).

doing(capture, Doing, For)   => Doing = "taking the image", For = "the image".
doing(estimate, Doing, For)  => Doing = "finding the pose", For = "the pose".
doing(predict, Doing, For)   => Doing = "weighing light", For = "a prediction".
doing(appraise, Doing, For)  => Doing = "looking at its tones", For = "its tones".
doing(discard, Doing, For)   => Doing = "dropping the image", For = "the vision server".
doing(move, Doing, For)      => Doing = "moving the target", For = "the target to move".
doing(start, Doing, For)     => Doing = "starting the servers", For = "the servers to start".
doing(describe, Doing, For)  => Doing = "starting the image server", For = "the image server to start".
doing(subscribe, Doing, For) => Doing = "listening to the image server", For = "the image server's events".
doing(Op, Doing, For)        => format(string(Doing), "~w", [Op]), format(string(For), "an answer to \"~w\"", [Op]).

%   How long it took, and how long it can take at the pace so far.
times(Times) :-
    statistics(epoch, Start),
    get_time(Now),
    Took is Now - Start,
    seconds_words(Took, TookWords),
    (   left(Now, Left, Most)
    ->  seconds_words(Left, LeftWords),
        format(string(LeftText), "~w~w left", [Most, LeftWords]),
        Times = [TookWords, LeftText]
    ;   Times = [TookWords]
    ).

left(Now, Left, Most) :-
    since(Began, Before),
    done(Done, Last),
    Done > Before,
    live(Limit),
    ( Limit = holds(All) -> Most = "about " ; All = Limit, Most = "at most " ),
    Pace is (Last - Began) / (Done - Before),
    Left is max(0, Pace * (All - Done) - (Now - Last)).

seconds_words(Seconds, Words) :-
    Whole is ceiling(Seconds),
    (   Whole < 60
    ->  format(string(Words), "~d s", [Whole])
    ;   Minutes is Whole // 60,
        Rest is Whole mod 60,
        format(string(Words), "~d min ~d s", [Minutes, Rest])
    ).
