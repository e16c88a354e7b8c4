:- module(domain_prediction,
          [ predict/4,                  % +Device, +Readings, +Settings, -Prediction
            fit/3,                      % +Device, +Readings, -Response
            predict_with/4,             % +Device, +Response, +Settings, -Prediction
            information/2               % +Prediction, -Bits
          ]).
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

:- use_module(device).
:- use_module(last_answer).
:- use_module(library(apply), [foldl/4, maplist/2, maplist/3]).
:- use_module(library(lists), [member/2, min_list/2, nth1/3, numlist/3, sum_list/2]).
:- set_prolog_flag(optimise, true).     % arithmetic is compiled, here alone

% Constants. Where no source is named they are chosen by hand, on simulated sessions and the six recorded stacks.
% What blur is expected was compared on 54 ray-traced hard scenes, and on 24 others: with 3 px^2 for either the second to
% fourth image chosen is worth 3 % less (the mean of its share right and its score where it is right, over the scenes).
nominal(p50, 0.25).                     % linear brightness expected before anything was seen: mid-grey,
nominal(p95, 0.5).                      % and highlights one stop above it
prior_trust(light, 0.002).              % weight of a prior beside a reading's 1: one reading decides nearly all
prior_trust(lens, 2.0).                 % lens and filter are known well enough: what is wider comes from
prior_trust(blur, 0.002).               %   aperture or shutter, and by the first readings rather from the aperture
prior_blur(lens, 1.0).                  % px^2: an edge of one pixel
prior_blur(defocus, 5.0).               % px^2, at the widest aperture: lenses that are wide blur by up to 4 px
prior_blur(motion, 0.5).                % px^2, at the reference shutter: 200 px/s at 1/60 s, edges across and along it
sun_share(0.5).                         % prior: the sun is like one light half on
least_blur_px2(0.25).                   % half a pixel: no lens and pixel do better
edge_contrast(0.4).                     % of a typical model edge, as a fraction of the brightness
grey_step(0.3).                         % standard deviation of rounding to whole grey values: 1 / sqrt(12)
crowding(0.05).                         % px^2 of variance for each px^3 of blur: what is not noise
clipped(0.97).                          % a percentile above this is saturated
safe_highlight(0.9).                    % predicted highlights above this lose edges,
overshoot_power(4).                     %   with this power of the excess
least_value(1.0e-4).                    % of a reading: below it an image is black
least_input(0.05).                      % light below which a reading says nothing about the scale
least_seen(1.0e-6).                     % against division by zero
fitting_sweeps(25).                     % of coordinate descent: coefficients then change by less than a thousandth

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
%   The coefficients above, as response(Middle, Highlight, Blur): one list each.  Those found last are remembered: they
%   are asked for when settings are chosen, when that is told, and when the image is compared with what was expected.

fit(Device, Readings, Response) :-
    last_answer(domain_prediction_fit, Device-Readings, fitted(Device, Readings), Response).

fitted(Device, Readings, response(Middle, Highlight, Blur)) :-
    findall(X-Y, ( member(Reading, Readings), light_reading(Device, p50, Reading, X, Y) ), Middles),
    findall(X-Y, ( member(Reading, Readings), light_reading(Device, p95, Reading, X, Y) ), Highlights),
    findall(X-Y, ( member(Reading, Readings), blur_reading(Device, Reading, X, Y) ), Blurs),
    light_prior(Device, p50, Middles, MiddlePrior),
    light_prior(Device, p95, Highlights, HighlightPrior),
    blur_prior(BlurPrior),
    non_negative_least_squares(Middles, MiddlePrior, Middle),
    non_negative_least_squares(Highlights, HighlightPrior, Highlight),
    non_negative_least_squares(Blurs, BlurPrior, Blur).

%!  information(+Prediction, -Bits) is det.
%
%   What an image tells of the place of an edge, against a variance of 1 px^2.

information(prediction(_, _, _, Variance), Bits) :-
    Bits is -log(Variance) / log(2).

%!  predict_with(+Device, +Response, +Settings, -Prediction) is det.

predict_with(Device, response(Middle, Highlight, Blur), Settings,
             prediction(Brightness, Brightest, BlurPx, Variance)) :-
    exposure(Device, Settings, Exposure),
    light_inputs(Device, Settings, X),
    dot(Middle, X, Y50),
    dot(Highlight, X, Y95),
    Brightness is Exposure * min(Y50, Y95),     % noise lifts the median of what is nearly black
    Brightest is Exposure * Y95,
    blur_inputs(Device, Settings, B),
    dot(Blur, B, Squared),
    least_blur_px2(Least),
    BlurPx is sqrt(max(Squared, Least)),
    edge_variance(Device, Brightness, Brightest, BlurPx, Variance).

%   Past saturation the edges of the brightest part are lost.
edge_variance(Device, Brightness, Brightest, BlurPx, Variance) :-
    least_seen(Least),
    Seen is max(min(Brightness, 1.0), Least),
    noise_variance(Device, Seen, Noise2),
    edge_contrast(Share),
    Contrast is Share * Seen,
    crowding(Crowding),
    safe_highlight(Safe),
    overshoot_power(Power),
    Overshoot is max(1.0, Brightest / Safe),
    Variance is (2 * sqrt(pi) * BlurPx * Noise2 / Contrast ** 2 + Crowding * BlurPx ** 3) * Overshoot ** Power.

%   Shot noise, read noise and rounding, on a linear scale where 1 is saturation.
noise_variance(Device, Seen, Noise2) :-
    device_sensor(Device, sensor(Gain, ReadE, FullWellE, Gamma)),
    FullScaleE is FullWellE / Gain,
    grey_step(Deviation),
    % a grey value is seen ** (1/Gamma): a step of it is wider in bright parts than in dark ones
    Step is Deviation / 255 * Gamma * Seen ** (1 - 1 / Gamma),
    Noise2 is Seen / FullScaleE + (ReadE / FullScaleE) ** 2 + Step ** 2.

                /*******************************
                *           READINGS           *
                *******************************/

light_reading(Device, Which, reading(Settings, Statistics), X, Y) :-
    Statistics = statistics(P50, P95, _, Saturated, _),
    ( Which == p50 -> Value = P50 ; Value = P95 ),
    exposure(Device, Settings, Exposure),
    light_inputs(Device, Settings, X),
    % a saturated reading says "at least": the more is saturated, the more is hidden
    clipped(Clipped),
    least_value(Least),
    (   Value > Clipped
    ->  Y is Value * 2 ** (1 + 2 * Saturated) / Exposure
    ;   Y is max(Value, Least) / Exposure
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
    device_reference(Device, exposure(Reference, _)),
    Motion is (Shutter / Reference) ** 2.

                /*******************************
                *            FITTING           *
                *******************************/

blur_prior([prior(Lens, LensTrust), prior(Defocus, Trust), prior(Motion, Trust)]) :-
    prior_blur(lens, Lens),
    prior_trust(lens, LensTrust),
    prior_blur(defocus, Defocus),
    prior_blur(motion, Motion),
    prior_trust(blur, Trust).

% All lights alike; the scale is what the readings say, or the nominal one at the
% reference exposure with every light half on.
light_prior(Device, Which, Readings, [prior(Sun, Trust)|Equal]) :-
    sun_share(Share),
    prior_trust(light, Trust),
    device_lights(Device, Lights),
    length(Lights, N),
    length(Ones, N),
    maplist(=(1.0), Ones),
    Unit = [Share|Ones],
    (   Readings == []
    ->  nominal(Which, Nominal),
        Scale is Nominal / (Share + 0.5 * N)
    ;   least_input(Least),
        findall(S, ( member(X-Y, Readings), dot(Unit, X, U), S is log(Y / max(U, Least)) ), Logs),
        sum_list(Logs, Sum),
        length(Logs, Count),
        Scale is exp(Sum / Count)
    ),
    Sun is Share * Scale,
    length(Equal, N),
    maplist(=(prior(Scale, Trust)), Equal).

%   Coordinate descent on  sum_i ((y_i - c.x_i) / y_i)^2 + sum_j w_j ((c_j - p_j) / p_j)^2,
%   c >= 0, from the priors prior(p_j, w_j).
non_negative_least_squares(Readings, Prior, Coefficients) :-
    maplist(prior_value, Prior, Start),
    fitting_sweeps(Sweeps),
    sweeps(Sweeps, Readings, Prior, Start, Coefficients).

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
