:- module(session_strategy_file,
          [ check_control/1,            % +File
            check_against_device/2,     % +File, +Device
            check_includes/1,           % +File
            check_instead/2,            % +Words, +Device
            strategy_files/2,           % +File, -Files
            strategy_sha256/2,          % +File, -Sha256
            in_strategy/3,              % +File, ?Term, -Place
            blocked/4,                  % +File, +Action, +Situation, -Message
            place_of/3                  % +File, +Terms, -Place
          ]).
/** <module> What is wrong with a strategy, said in plain words with the place in its file

The interpreter checks what any program can get wrong; here is what only the theory of lights and camera knows.
*/

:- use_module(session_file, [file_sha256/2]).
:- use_module(usage, [did_you_mean/3, usage_error/2]).
:- use_module('../domain/reasoning/device').
:- use_module('../domain/reasoning/instead', [instead_lights/2, instead_settings/3]).
:- use_module('../domain/reasoning/qualitative', [settings_words/3, shutter_words/2]).
:- use_module('../indigolog/indigolog', [fluent_value/3]).
:- use_module(library(apply), [maplist/3]).
:- use_module(library(lists), [append/2, append/3, member/2, memberchk/2, nth1/3]).
:- use_module(library(pairs), [pairs_keys/2]).
:- use_module(library(readutil), [read_file_to_string/3]).
:- use_module(library(sha), [hash_atom/2, sha_hash/3]).

%!  check_includes(+File) is det.
%
%   @error usage_error(Message) where a file includes itself, or one that includes it: it can only be asked before it is loaded

check_includes(File) :-
    strategy_files(File, _).

%!  check_control(+File) is det.
%
%   @error usage_error(Message) where the strategy has no `control`

check_control(File) :-
    findall(Name, ( in_strategy(File, proc(Head, _), _), callable(Head), functor(Head, Name, 0) ), Names),
    (   memberchk(control, Names)
    ->  true
    ;   ( member(Near, Names), dwim_match(Near, control) -> format(atom(Hint), " Is ~w meant for it?", [Near]) ; Hint = '' ),
        usage_error("~w: it defines no `control`, the procedure that a session runs: proc(control, [...]).~w",
                    [File, Hint])
    ).

%!  check_against_device(+File, +Device) is det.
%
%   What the strategy names is there.
%
%   @error usage_error(Message)

check_against_device(File, Device) :-
    device_lights(Device, Lights),
    findall(Light, member(light(Light, _), Lights), Names),
    forall(( in_strategy(File, working(Light), Place), atom(Light), \+ memberchk(Light, Names) ),
           ( format(atom(Where), "~w: working(~w)", [Place, Light]), no_light(Where, Light, Names) )),
    forall(( member(Action-Settings, [choose(Settings)-Settings, capture(_, Settings)-Settings]),
             in_strategy(File, Action, Place),
             ground(Settings),
             settings_problem(Device, Settings, Problem) ),
           usage_error("~w: ~s", [Place, Problem])).

%!  check_instead(+Words, +Device) is det.
%
%   The device offers the settings that an image is to be taken under instead of those that the strategy chooses.
%
%   @error usage_error(Message)

check_instead(Words, Device) :-
    (   instead_lights(Words, Named),
        append(_, [Twice|Others], Named),
        memberchk(Twice, Others)
    ->  usage_error("--instead: the light ~w is named twice", [Twice])
    ;   instead_settings(Words, Device, Settings)
    ->  (   settings_problem(Device, Settings, Problem)
        ->  usage_error("--instead: ~s", [Problem])
        ;   true
        )
    ;   instead_lights(Words, Named),
        findall(Name, ( device_lights(Device, Lights), member(light(Name, _), Lights) ), Names),
        member(Light, Named),
        \+ memberchk(Light, Names)
    ->  no_light('--instead', Light, Names)
    ;   reference_settings(Device, Example),
        settings_words(Device, Example, Shown),
        usage_error("--instead: '~w' does not tell lights, shutter and aperture, as 'i3: ~s' does", [Words, Shown])
    ).

no_light(Where, Light, Names) :-
    atomic_list_concat(Names, ', ', Known),
    did_you_mean(Light, Names, Hint),
    usage_error("~w: there is no light ~w; there are ~w.~w", [Where, Light, Known, Hint]).

%   In pi and some a lower-case name of one letter or bound by it is a variable: only settings(...) are looked at.
settings_problem(Device, settings(Levels, Shutter0, Aperture), Problem) :-
    is_list(Levels),
    catch(Shutter is Shutter0, error(_, _), fail),
    number(Aperture),
    \+ settings_in_range(Device, settings(Levels, Shutter, Aperture)),
    device_lights(Device, Lights),
    (   length(Lights, Count), \+ length(Levels, Count)
    ->  length(Levels, Given),
        findall(Name, member(light(Name, _), Lights), Names),
        atomic_list_concat(Names, ', ', Known),
        format(string(Problem), "settings with ~d light levels, but there are ~d lights: ~w", [Given, Count, Known])
    ;   nth1(N, Levels, Level), nth1(N, Lights, light(Name, Range)), integer(Range),
        \+ ( integer(Level), between(1, Range, Above), Level =:= Above - 1 )
    ->  Top is Range - 1,
        format(string(Problem), "light ~w has no level ~w; it has 0 to ~d", [Name, Level, Top])
    ;   device_shutters(Device, Shutters), \+ in_range_with(Device, Levels, Shutter, _)
    ->  maplist(shutter_words, Shutters, Words),
        atomic_list_concat(Words, ', ', Known),
        format(string(Problem), "a shutter of ~w s is not offered; there are ~w", [Shutter0, Known])
    ;   device_apertures(Device, Apertures),
        atomic_list_concat(Apertures, ', ', Known),
        format(string(Problem), "an aperture of ~w is not offered; there are ~w", [Aperture, Known])
    ).

in_range_with(Device, Levels, Shutter, Aperture) :-
    device_apertures(Device, Apertures),
    member(Aperture, Apertures),
    settings_in_range(Device, settings(Levels, Shutter, Aperture)),
    !.

%!  blocked(+File, +Action, +Situation, -Message) is semidet.
%
%   Why an action of the theory is not possible in Situation, and where in the strategy it may be.

blocked(File, Action, Situation, Message) :-
    fluent_value(device, Situation, Device),
    fluent_value(candidate, Situation, Candidate),
    fluent_value(measured, Situation, Measured),
    fluent_value(settings, Situation, Settings),
    why(Action, state(Device, Candidate, Measured, Settings), Format, Arguments),
    format(string(Why), Format, Arguments),
    place(File, Action, Place),
    format(string(Message), "~w: ~s", [Place, Why]).

why(choose(S), state(Device, _, _, _), "~s", [Problem]) :-
    settings_problem(Device, S, Problem).
why(capture(_, _), state(_, Image, _, _), "the image ~w is neither kept nor discarded yet: keep_image or drop_image it first",
    [Image]) :-
    Image \== none.
why(capture(_, _), state(_, _, _, unknown), "an image is taken without settings: choose some first, for example choose_random", []).
why(capture(_, S), state(_, _, _, Settings), "an image is taken under the settings that were chosen: choose them first", []) :-
    S \= Settings.
why(Action, state(_, none, _, _), "there is no image to ~w: take_image first", [Name]) :-
    member(Action-Name, [keep(_)-keep, discard(_, _)-discard]).
why(Action, state(_, Candidate, _, _), "~w is not the image that was taken last: that is ~w", [Image, Candidate]) :-
    member(Action, [keep(Image), discard(Image, _)]),
    Image \== Candidate.
why(keep(Image), state(_, Image, Measured, _), "the image ~w is kept before it is measured: measure comes first", [Image]) :-
    \+ memberchk(Image, Measured).
why(Action, state(_, Image, _, _), "the image ~w is neither kept nor discarded yet: keep_image or drop_image it first", [Image]) :-
    memberchk(Action, [advance(_), start_over]),
    Image \== none.
why(estimate([]), _, "there is no image to measure: take_image first", []).

place(File, Action, Place) :-
    functor(Action, Name, _),
    findall(Doer, done_by(Name, Doer), Doers),
    findall(Line, ( member(Doer, Doers), in_file(File, Doer, Line) ), Lines),
    lines_place(File, Lines, Place).

lines_place(File, Lines, Place) :-
    (   sort(Lines, [Line])
    ->  format(atom(Place), "~w:~d", [File, Line])
    ;   sort(Lines, [First|More])
    ->  atomic_list_concat([First|More], ', ', Listed),
        format(atom(Place), "~w, line ~w", [File, Listed])
    ;   Place = File
    ).

%!  place_of(+File, +Terms, -Place) is det.
%
%   Where the first of Terms that is anywhere in the strategy may be; its file alone where none is.

place_of(File, Terms, Place) :-
    strategy_files(File, Files),
    (   member(Term, Terms),
        nonvar(Term),
        member(One, Files),
        findall(Line, in_file(One, Term, Line), Lines),
        Lines \== []
    ->  lines_place(One, Lines, Place)
    ;   Place = File
    ).

done_by(capture, capture(_, _)).
done_by(capture, take_image).
done_by(keep, keep(_)).
done_by(keep, keep_image).
done_by(discard, discard(_, _)).
done_by(discard, drop_image(_)).
done_by(choose, choose(_)).
done_by(estimate, estimate(_)).
done_by(estimate, measure).
done_by(advance, advance(_)).
done_by(start_over, start_over).

                /*******************************
                *        TERMS OF A FILE       *
                *******************************/

%!  in_strategy(+File, ?Term, -Place) is nondet.
%
%   Where Term is in the file, or in one that it includes; its own come first.

in_strategy(File, Term, Place) :-
    strategy_files(File, Files),
    member(One, Files),
    in_file(One, Term, Line),
    format(atom(Place), "~w:~d", [One, Line]).

%!  strategy_files(+File, -Files) is det.
%
%   The file, and after it those that it includes, at any depth.

strategy_files(File, Files) :-
    with_included([], File, Files).

%   Above are the files that include it, the nearest first.
with_included(Above, File, [File|Files]) :-
    findall(Other-Line, included(File, Other, Line), Pairs),
    forall(( member(Other-Line, Pairs), member(One, [File|Above]), same_file(Other, One) ),
           usage_error("~w:~d: it includes ~w, which is included by it: loading would never end", [File, Line, Other])),
    pairs_keys(Pairs, Others),
    maplist(with_included([File|Above]), Others, Lists),
    append(Lists, Files).

included(File, Other, Line) :-
    in_file(File, (:- include(Given)), Line),
    ground(Given),
    absolute_file_name(Given, Other, [extensions(['', pl]), access(read), relative_to(File), file_errors(fail)]).

%!  strategy_sha256(+File, -Sha256) is det.
%
%   Of the file alone where it includes none, else of those of all.

strategy_sha256(File, Sha256) :-
    strategy_files(File, Files),
    maplist(file_sha256, Files, Hashes),
    (   Hashes = [Sha256]
    ->  true
    ;   atomic_list_concat(Hashes, All),
        sha_hash(All, Bytes, [algorithm(sha256), encoding(utf8)]),
        hash_atom(Bytes, Sha256)
    ).

%   in_file(+File, ?Term, -Line): where Term is in the file, at any depth; nothing of what cannot be read.
in_file(File, Term, Line) :-
    catch(file_terms(File, Text, Terms), error(_, _), fail),
    member(Read-Position, Terms),
    copy_term(Term, Wanted),
    subterm(Read, Position, Wanted, At),
    Term = Wanted,
    sub_string(Text, 0, At, _, Before),
    split_string(Before, "\n", "", Lines),
    length(Lines, Line).

file_terms(File, Text, Terms) :-
    read_file_to_string(File, Text, [encoding(utf8)]),
    setup_call_cleanup(open_string(Text, Stream), positioned(Stream, Terms), close(Stream)).

positioned(Stream, Terms) :-
    read_term(Stream, Term, [subterm_positions(Position)]),
    (   Term == end_of_file
    ->  Terms = []
    ;   Terms = [Term-Position|More],
        positioned(Stream, More)
    ).

subterm(Term, Position, Wanted, At) :-
    nonvar(Term),
    Term = Wanted,
    begins(Position, At).
subterm(Term, term_position(_, _, _, _, Positions), Wanted, At) :-
    nth1(N, Positions, Position),
    arg(N, Term, Argument),
    subterm(Argument, Position, Wanted, At).
subterm(List, list_position(_, _, Positions, _), Wanted, At) :-
    nth1(N, Positions, Position),
    nth1(N, List, Element),
    subterm(Element, Position, Wanted, At).
subterm(Term, parentheses_term_position(_, _, Position), Wanted, At) :-
    subterm(Term, Position, Wanted, At).

begins(From-_, From).
begins(term_position(From, _, _, _, _), From).
begins(list_position(From, _, _, _), From).
begins(parentheses_term_position(From, _, _), From).
