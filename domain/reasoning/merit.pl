:- module(domain_merit,
          [ merit/2,                    % +Fix, -MeritPx
            improves/2,                 % +Fix, +MeritPx
            no_worse/2,                 % +Fix, +MeritPx
            rather_right/1,             % +MeritPx
            held_back/3,                % +Fix, +ThresholdPx, -Ambiguity
            still_held_back/3,          % +Fix, +ThresholdPx, +Ambiguity
            fix_rms/2,                  % +Fix, -RmsPx
            worst_merit/1,              % -MeritPx
            default_threshold/1         % -MeritPx
          ]).

/** <module> How far a pose estimate can be trusted

A fix is `none` or

    fix(pose(RotationVector, Translation), Covariance,
        quality(RmsPx, Uncertainty, Support, Score, Ambiguity), Lines)

as the vision server measured it: `Score` is the chance that the pose is right to
1 degree and 1 % of the range, `Ambiguity` how good the best other pose is (0 to
1), `Lines` a list of
line(Index, VisiblePx, Support, RmsPx).
*/

%!  worst_merit(-MeritPx) is det.
%
%   The merit of no pose at all.

worst_merit(100.0).

%!  default_threshold(-MeritPx) is det.
%
%   Where a pose is trusted unless the user says otherwise: at a score of 0.933, see weight(doubt, _).

default_threshold(1.0).

%   What doubt counts, and what is worth an image; chosen by hand.  The weight fixes the score at which a pose is trusted,
%   1 - 1/15 by the default threshold of 1 px.  docs/trust.md says what 10 (0.9) and 20 (0.95) would be worth.
weight(doubt, 15).                      % a percent counts as 0.15 px
improvement(0.98).                      % of the merit: two percent less
scatter(1.25).                          % of the merit from one image to the next that adds nothing
cleared(0.99).                          % of a rival's chance: more is left by an image that does not tell it apart

%!  merit(+Fix, -MeritPx) is det.
%
%   Doubt that the pose is right to 1 degree and 1 % of the range: 1.0 stands for a
%   chance of 93 %.

merit(none, Merit) :-
    worst_merit(Merit).
merit(fix(_, _, quality(_, _, _, Score, _), _), Merit) :-
    weight(doubt, D),
    Merit is D * (1 - Score).

%!  improves(+Fix, +MeritPx) is semidet.
%
%   Fix is better than Merit by enough to be worth an image.

improves(Fix, Merit) :-
    merit(Fix, New),
    improvement(Share),
    New < Share * Merit.

%!  rather_right(+MeritPx) is semidet.
%
%   A pose of this merit is rather right than wrong.

rather_right(Merit) :-
    weight(doubt, Doubt),
    Merit =< 0.5 * Doubt.

%!  no_worse(+Fix, +MeritPx) is semidet.
%
%   Fix is as good as Merit, but for what the scatter of estimates explains.

no_worse(Fix, Merit) :-
    merit(Fix, New),
    scatter(Share),
    New =< Share * Merit.

%!  held_back(+Fix, +ThresholdPx, -Ambiguity) is semidet.
%
%   Fix would be trusted but for another pose, which is so likely beside it.

held_back(fix(_, _, quality(_, _, _, Score, Ambiguity), _), Threshold, Ambiguity) :-
    weight(doubt, D),
    D * (1 - Score) >= Threshold,
    D * (1 - Score * (1 + Ambiguity)) < Threshold.

%!  still_held_back(+Fix, +ThresholdPx, +Ambiguity) is semidet.
%
%   Fix is held back by a pose that is as likely beside it as Ambiguity, that of the estimate before it, or likelier.

still_held_back(Fix, Threshold, Before) :-
    number(Before),
    held_back(Fix, Threshold, Ambiguity),
    cleared(Share),
    Ambiguity >= Share * Before.

%!  fix_rms(+Fix, -RmsPx) is semidet.

fix_rms(fix(_, _, quality(Rms, _, _, _, _), _), Rms).
