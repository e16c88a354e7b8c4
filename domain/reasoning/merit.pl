:- module(domain_merit,
          [ merit/2,                    % +Fix, -MeritPx
            improves/2,                 % +Fix, +MeritPx
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
%   Where a pose is trusted unless the user says otherwise.

default_threshold(1.0).

%   What each part counts, and what is worth an image: docs/trust.md says how they were checked.
weight(rms, 0.25).                      % px for a px of error
weight(uncertainty, 200).               % a permille counts as 0.2 px
weight(doubt, 10).                      % a percent counts as 0.1 px
improvement(0.98).                      % of the merit: two percent less

%!  merit(+Fix, -MeritPx) is det.
%
%   The error of the fit joined with what the fit cannot know: its uncertainty (one
%   standard deviation, 0.01 for 1 % of the range or 1 degree) and the chance that it
%   is wrong altogether, so that neither an easy error nor a sharp wrong pose is enough.

merit(none, Merit) :-
    worst_merit(Merit).
merit(fix(_, _, quality(Rms, Uncertainty, _, Score, _), _), Merit) :-
    worst_merit(Worst),
    weight(rms, R),
    weight(uncertainty, U),
    weight(doubt, D),
    Merit is min(Worst, R * Rms + U * Uncertainty + D * (1 - Score)).

%!  improves(+Fix, +MeritPx) is semidet.
%
%   Fix is better than Merit by enough to be worth an image.

improves(Fix, Merit) :-
    merit(Fix, New),
    improvement(Share),
    New < Share * Merit.

%!  fix_rms(+Fix, -RmsPx) is semidet.

fix_rms(fix(_, _, quality(Rms, _, _, _, _), _), Rms).
