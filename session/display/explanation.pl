:- module(session_explanation,
          [ explanation//2              % +Device, +Reason
          ]).
/** <module> The lines of `--explain`: why these settings, what the image shows, what it changed */

:- use_module(outcome, [merit_words/2]).
:- use_module('../../domain/reasoning/prediction', [information/2]).
:- use_module('../../domain/reasoning/qualitative').
:- use_module(library(apply), [maplist/3]).

%!  explanation(+Device, +Reason)// is det.
%
%   Reason is one of decision_reason/3.

explanation(Device, chosen(Settings, why(_, Promise, Prediction), [ranked(_, Other, _)|_], _, _)) -->
    { Other \== Settings,              % such as the safe first image of `informed`
      settings_words(Device, Settings, Words) },
    !,
    [ ansi(fg(cyan), '       chose ~w: not for its promise, ~2f; expects ', [Words, Promise]) ],
    expected(Prediction).
explanation(Device, chosen(Settings, Why, Best, Count, LeftOut)) -->
    { Why \== none,
      settings_words(Device, Settings, Words),
      worth_words(Why, Worth, Prediction) },
    !,
    [ ansi(fg(cyan), '       chose ~w: ~w; expects ', [Words, Worth]) ],
    expected(Prediction),
    others(Best, Settings, Device),
    [ nl, ansi(fg(cyan), '       of ~d candidates ', [Count]) ],
    left_out(Why, LeftOut).
explanation(Device, chosen(Settings, none, _, _, _)) -->
    { settings_words(Device, Settings, Words) },
    [ ansi(fg(cyan), '       chose ~w: not by promise', [Words]) ].
explanation(_, seen(statistics(P50, P95, Dark, Saturated, Blur), Quality, Prediction)) -->
    { maplist(percent, [P50, P95, Dark, Saturated], [Median, Highlights, DarkPercent, SaturatedPercent]) },
    [ ansi(fg(cyan), '       saw a ~w image: median ~0f %, highlights ~0f %', [Quality, Median, Highlights]) ],
    blur_words(Blur),
    [ ansi(fg(cyan), ', dark ~0f %, saturated ~0f %; expected were ', [DarkPercent, SaturatedPercent]) ],
    expected(Prediction).
explanation(_, measured(fix(_, _, quality(Rms, Uncertainty, Support, Score, Ambiguity), _), New, Old)) -->
    { Permille is 1000 * Uncertainty, Percent is 100 * Support,
      maplist(merit_words, [New, Old], Merits) },
    [ ansi(fg(cyan), '       rms ~2f px, uncertainty ~2f permille, ~0f % of the lines found, score ~2f, ambiguity ~2f; ',
           [Rms, Permille, Percent, Score, Ambiguity]),
      ansi(fg(cyan), 'merit ~w (was ~w)', Merits) ].
explanation(_, measured(none, _, _)) -->
    [ ansi(fg(cyan), '       no pose in these images', []) ].

expected(prediction(Brightness, Highlight, Blur, _)) -->
    { maplist(percent, [Brightness, Highlight], Percents) },
    [ ansi(fg(cyan), 'median ~0f %, highlights ~0f %', Percents) ],
    blur_words(Blur).

%   An image in which nothing is sharp enough tells no width.
blur_words(Blur) -->
    { number(Blur) },
    !,
    [ ansi(fg(cyan), ', edges ~1f px wide', [Blur]) ].
blur_words(_) -->
    [].

left_out(why(_, _, _), left_out(Alike, Unfavourable)) -->
    [ ansi(fg(cyan), '~d left out as too like a kept image, ~d as like an unfavourable state; the others promise less',
           [Alike, Unfavourable]) ].
left_out(adds(_, _, _), left_out(_, Unfavourable)) -->
    [ ansi(fg(cyan), '~d left out as like an unfavourable state; the others add less', [Unfavourable]) ].

others([], _, _) -->
    [].
others([ranked(_, Settings, _)|Others], Settings, Device) -->
    !,
    others(Others, Settings, Device).
others([ranked(_, Other, Why)|Others], Settings, Device) -->
    { settings_words(Device, Other, Words), worth_words(Why, Worth, Prediction) },
    [ nl, ansi(fg(cyan), '         rather than ~w: ~w, ', [Words, Worth]) ],
    expected(Prediction),
    others(Others, Settings, Device).

worth_words(why(_, Promise, Prediction), Words, Prediction) :-
    information(Prediction, Bits),
    Likely is Promise - Bits,
    format(atom(Words), "promise ~2f (~2f bit, ~2f for likelihood)", [Promise, Bits, Likely]).
worth_words(adds(Bits, Line, Prediction), Words, Prediction) :-
    format(atom(Words), "adds ~2f bit, most to line ~w", [Bits, Line]).


percent(Fraction, Percent) :-
    Percent is 100 * Fraction.
