:- module(domain_prediction,
          [ predict/4,                  % +Device, +Readings, +Settings, -Prediction
            fit/3,                      % +Device, +Readings, -Response
            predict_with/4              % +Device, +Response, +Settings, -Prediction
          ]).
:- use_module(device).
:- use_module(library(apply), [foldl/4, maplist/2, maplist/3]).
:- use_module(library(lists), [member/2, min_list/2, nth1/3, numlist/3, sum_list/2]).

/** <module> What an image under new settings would look like

Light adds up.  With exposure e and light outputs x_l (fractions of full), the
linear brightness of the target is

    y = e (a_0 + sum_l a_l x_l)                  a_0: sun and sky, a_l: light l

and the squared width of its edges is

    s^2 = b_0 + b_1 (A_min / A)^2 + b_2 (t / t_ref)^2      defocus, motion blur

with aperture A and shutter t.  All coefficients are non-negative and unknown;
each image taken so far is one reading of both sums.  They are estimated by
non-negative least squares with a prior, so that one reading already says
something and ten say nearly all.

The worth of an image is the inverse of the variance with which it places one
edge: for a step of height C blurred by s in white noise of standard deviation
n, the Cramer-Rao bound is 2 sqrt(pi) s n^2 / C^2 px^2.  What is not noise
(texture and neighbouring edges that run into each other) grows much faster with
the blur: on recorded stacks with 4 px of defocus a dark image at f/5.6 fixed the
pose to 0.4 degrees where a bright one at f/2.8 was 1.2 degrees off.

A reading is reading(Settings, Statistics), with the statistics
statistics(P50, P95, Dark, Saturated, BlurPx) of the target's region, the first
two in fractions of full scale on a linear scale; BlurPx is `unknown` where no
edge was measured.
*/

%!  predict(+Device, +Readings, +Settings, -Prediction) is det.
%
%   Prediction is prediction(Brightness, Highlight, BlurPx, EdgeVariance): the
%   median and the 95th percentile of the target on a linear scale where 1 is
%   saturation, the width of an edge in px, and the variance of its place in px^2.

predict(Device, Readings, Settings, Prediction) :-
    fit(Device, Readings, Response),
    predict_with(Device, Response, Settings, Prediction).

%!  fit(+Device, +Readings, -Response) is det.
%
%   The coefficients above, as response(Middle, Highlight, Blur): one list each.

fit(Device, Readings, response(Middle, Highlight, Blur)) :-
    findall(X-Y, ( member(Reading, Readings), light_reading(Device, p50, Reading, X, Y) ), Middles),
    findall(X-Y, ( member(Reading, Readings), light_reading(Device, p95, Reading, X, Y) ), Highlights),
    findall(X-Y, ( member(Reading, Readings), blur_reading(Device, Reading, X, Y) ), Blurs),
    light_prior(Device, 0.25, Middles, MiddlePrior),
    light_prior(Device, 0.5, Highlights, HighlightPrior),
    non_negative_least_squares(Middles, MiddlePrior, Middle),
    non_negative_least_squares(Highlights, HighlightPrior, Highlight),
    % lens and filter are known well enough: what is wider comes from aperture or shutter
    non_negative_least_squares(Blurs, [prior(1.0, 2.0), prior(0.5, 0.002), prior(0.5, 0.002)], Blur).

%!  predict_with(+Device, +Response, +Settings, -Prediction) is det.

predict_with(Device, response(Middle, Highlight, Blur), Settings,
             prediction(Brightness, Brightest, BlurPx, Variance)) :-
    exposure(Device, Settings, Exposure),
    light_inputs(Device, Settings, X),
    dot(Middle, X, Y50),
    dot(Highlight, X, Y95),
    Brightness is Exposure * Y50,
    Brightest is Exposure * Y95,
    blur_inputs(Device, Settings, B),
    dot(Blur, B, Squared),
    BlurPx is sqrt(max(Squared, 0.25)),
    edge_variance(Device, Brightness, Brightest, BlurPx, Variance).

%   The contrast of a typical model edge is taken as 0.4 of the brightness.  Past
%   saturation the edges of the brightest part are lost.
edge_variance(Device, Brightness, Brightest, BlurPx, Variance) :-
    device_sensor(Device, sensor(Gain, ReadE, FullWellE, Gamma)),
    FullScaleE is FullWellE / Gain,
    Seen is max(min(Brightness, 1.0), 1.0e-6),
    % a grey value is seen ** (1/Gamma): a step of it is wider in bright parts than in dark ones
    Step is 0.3 / 255 * Gamma * Seen ** (1 - 1 / Gamma),
    Noise2 is Seen / FullScaleE + (ReadE / FullScaleE) ** 2 + Step ** 2,
    Contrast is 0.4 * Seen,
    Overshoot is max(1.0, Brightest / 0.9),
    Variance is ( 2 * sqrt(pi) * BlurPx * Noise2 / Contrast ** 2
                + 0.05 * BlurPx ** 3
                ) * Overshoot ** 4.

                /*******************************
                *           READINGS           *
                *******************************/

light_reading(Device, Which, reading(Settings, Statistics), X, Y) :-
    Statistics = statistics(P50, P95, _, Saturated, _),
    ( Which == p50 -> Value = P50 ; Value = P95 ),
    exposure(Device, Settings, Exposure),
    light_inputs(Device, Settings, X),
    % a saturated reading says "at least": the more is saturated, the more is hidden
    (   Value > 0.97
    ->  Y is Value * 2 ** (1 + 2 * Saturated) / Exposure
    ;   Y is max(Value, 1.0e-4) / Exposure
    ).

blur_reading(Device, reading(Settings, Statistics), X, Y) :-
    Statistics = statistics(_, _, _, _, BlurPx),
    number(BlurPx),
    blur_inputs(Device, Settings, X),
    Y is BlurPx ** 2.

exposure(Device, Settings, Exposure) :-
    exposure_stops(Device, Settings, Stops),
    Exposure is 2 ** Stops.

light_inputs(Device, settings(Levels, _, _), [1.0|Fractions]) :-
    level_fractions(Device, Levels, Fractions).

blur_inputs(Device, settings(_, Shutter, Aperture), [1.0, Defocus, Motion]) :-
    device_apertures(Device, Apertures),
    min_list(Apertures, Widest),
    Defocus is (Widest / Aperture) ** 2,
    Motion is (Shutter * 60) ** 2.

                /*******************************
                *            FITTING           *
                *******************************/

% All lights alike, and the sun like one light half on; the scale is what the
% readings say, or Nominal at the reference exposure with every light half on.
light_prior(Device, Nominal, Readings, [prior(Half, 0.002)|Equal]) :-
    device_lights(Device, Lights),
    length(Lights, N),
    length(Ones, N),
    maplist(=(1.0), Ones),
    Unit = [0.5|Ones],
    (   Readings == []
    ->  Scale is Nominal / (0.5 + 0.5 * N)
    ;   findall(S, ( member(X-Y, Readings), dot(Unit, X, U), S is log(Y / max(U, 0.05)) ), Logs),
        sum_list(Logs, Sum),
        length(Logs, Count),
        Scale is exp(Sum / Count)
    ),
    Half is 0.5 * Scale,
    length(Equal, N),
    maplist(=(prior(Scale, 0.002)), Equal).

%   Coordinate descent on  sum_i ((y_i - c.x_i) / y_i)^2 + sum_j w_j ((c_j - p_j) / p_j)^2,
%   c >= 0, from the priors prior(p_j, w_j).
non_negative_least_squares(Readings, Prior, Coefficients) :-
    maplist(prior_value, Prior, Start),
    sweeps(25, Readings, Prior, Start, Coefficients).

prior_value(prior(Value, _), Value).

sweeps(0, _, _, Coefficients, Coefficients) :- !.
sweeps(N, Readings, Prior, Coefficients0, Coefficients) :-
    length(Prior, Length),
    numlist(1, Length, Indices),
    foldl(descend(Readings, Prior), Indices, Coefficients0, Coefficients1),
    N1 is N - 1,
    sweeps(N1, Readings, Prior, Coefficients1, Coefficients).

descend(Readings, Prior, J, Coefficients0, Coefficients) :-
    nth1(J, Coefficients0, Old),
    nth1(J, Prior, prior(P, Trust)),
    PriorWeight is Trust / P ** 2,
    foldl(normal_equation(J, Old, Coefficients0), Readings,
          PriorWeight-(PriorWeight * P), A-B),
    New is max(B / A, 0.0),
    replace(J, Coefficients0, New, Coefficients).

normal_equation(J, Old, Coefficients, X-Y, A0-B0, A-B) :-
    nth1(J, X, Xj),
    dot(Coefficients, X, Fitted),
    Rest is Fitted - Old * Xj,
    Weight is 1 / Y ** 2,
    A is A0 + Weight * Xj * Xj,
    B is B0 + Weight * Xj * (Y - Rest).

replace(1, [_|Tail], New, [New|Tail]) :- !.
replace(J, [Head|Tail0], New, [Head|Tail]) :-
    J1 is J - 1,
    replace(J1, Tail0, New, Tail).

dot(Xs, Ys, Dot) :-
    dot_(Xs, Ys, 0.0, Dot).

dot_([], [], Dot, Dot).
dot_([X|Xs], [Y|Ys], Dot0, Dot) :-
    Dot1 is Dot0 + X * Y,
    dot_(Xs, Ys, Dot1, Dot).
