:- module(session_outcome,
          [ advised/4,                  % +Images, +Readings, +Result, -Advised
            counted/3,                  % +Count, +Name, -Words
            merit_words/2               % +Px, -Words
          ]).
/** <module> What came of a session, in words: the last lines in the terminal

Messages session_outcome(Result): the dict that result.json is made from.
*/

:- use_module('../../domain/reasoning/merit', [held_back/3]).
:- use_module('../../domain/reasoning/surprises', [cause_words/2]).
:- use_module(library(aggregate), [aggregate_all/3]).
:- use_module(library(dcg/high_order), [sequence//2]).
:- use_module(library(lists), [last/2, member/2, memberchk/2, reverse/2]).

%!  advised(+Images, +Readings, +Result, -Advised) is det.
%
%   The result with what to try, as `advice`, where the threshold was not reached.  Images is images(Limit, Recorded): so
%   many were allowed, and there are (`inf` where each request gives another one).  Readings are of the images of the last
%   scene.

advised(Images, Readings, Result, Advised) :-
    Result.status == exhausted,
    !,
    Pose = Result.pose,
    findall(Help, ( Pose == null, without_pose(Result, Readings, Help) ; help(Result, Images, Help) ), Helps),
    Advised = Result.put(advice, Helps).
advised(_, _, Result, Result).

%!  counted(+Count, +Name, -Words) is det.
%
%   So many, in the plural where they are not one.

counted(Count, Name, Words) :-
    ( Count =:= 1 -> Plural = '' ; Plural = s ),
    format(atom(Words), "~d ~w~w", [Count, Name, Plural]).

%!  merit_words(+Px, -Words) is det.
%
%   A merit or a threshold, in pixels: to a hundredth, and where that would say little in two significant digits.

merit_words(Px, Words) :-
    least_in_hundredths(Least),
    (   ( Px =:= 0 ; abs(Px) >= Least )
    ->  format(atom(Words), "~2f", [Px])
    ;   format(atom(Words), "~2g", [Px])
    ).

least_in_hundredths(0.1).

:- multifile prolog:message//1.

prolog:message(session_outcome(Result)) -->
    { counted(Result.iterations, image, Images), kept_words(Result, Kept) },
    headline(Result.status),
    [ ' after ~w, ~w, ~1f s'-[Images, Kept, Result.seconds.total] ],
    hold_points(Result),
    pose_words(Result),
    error_words(Result),
    model_words(Result),
    last_fixed(Result),
    what_may_help(Result).

headline(converged) -->
    [ ansi([bold, fg(green)], 'Pose found', []) ].
headline(exhausted) -->
    [ ansi([bold, fg(yellow)], 'Not trusted: the threshold was not reached', []) ].
headline(stopped) -->
    [ ansi([bold, fg(red)], 'Stopped', []) ].

%   How many were kept; and of how many the pose is, where the target has moved, or the sun changed, since.
kept_words(Result, Words) :-
    length(Result.kept, Kept),
    (   is_dict(Result.pose),
        last(Result.steps, Step),
        Step.set_size < Kept
    ->  format(atom(Words), "~d kept, the pose from the last ~d", [Kept, Step.set_size])
    ;   format(atom(Words), "~d kept", [Kept])
    ).

hold_points(Result) -->
    { Planned = Result.get(planned_holds_m) },
    !,
    { length(Planned, Count),
      aggregate_all(count, ( member(Hold, Result.holds), Hold.status \== aborted ), Fixed),
      counted(Count, 'hold point', Points) },
    [ nl, '  pose fixed at ~d of ~w'-[Fixed, Points] ].
hold_points(_) -->
    [].

pose_words(Result) -->
    { is_dict(Result.pose) },
    !,
    { Result.pose.translation = [X, Y, Z],
      Result.pose.rotation_vector = [A, B, C],
      merit_words(Result.merit_px, Merit) },
    [ nl, '  translation ~4f ~4f ~4f m'-[X, Y, Z], nl,
      '  rotation    ~4f ~4f ~4f rad'-[A, B, C], nl,
      '  rms ~2f px, merit ~w px (threshold ~g)'-[Result.rms_px, Merit, Result.threshold_px] ],
    other_poses(Result),
    free_turns(Result).
pose_words(_) -->
    [ nl, '  no pose' ].

%   Of round targets.
free_turns(Result) -->
    { Axes = Result.get(free) },
    !,
    sequence(free_turn, Axes).
free_turns(_) -->
    [].

free_turn([X, Y, Z]) -->
    [ nl, '  no image clearly tells how it is turned about its axis ~2f ~2f ~2f'-[X, Y, Z] ].

%   What else the images fit, where nothing was known beforehand; all of it is in result.json.
other_poses(Result) -->
    { several_poses(Result, Count, First) },
    !,
    { Percent is 100 * First.probability },
    [ nl, '  one of ~d poses that fit, its probability ~0f %'-[Count, Percent] ].
other_poses(_) -->
    [].

several_poses(Result, Count, First) :-
    Result.get(poses) = [First|Others],
    length([First|Others], Count),
    Count > 1.

error_words(Result) -->
    { Error = Result.get(error) },
    !,
    { Percent is 100 * Error.translation_fraction_of_range,
      Millimetres is 1000 * Error.translation_m },
    [ nl, '  true error ~3f deg, ~2f mm (~3f % of range)'-[Error.rotation_deg, Millimetres, Percent] ].
error_words(_) -->
    [].

model_words(Result) -->
    { Wrong = Result.get(model_wrong) },
    !,
    { cause_words(model_wrong(Wrong.axis, Wrong.share), Words) },
    [ nl, ansi(fg(yellow), '  ~w', [Words]) ].
model_words(_) -->
    [].

%   An approach that did not come to its end has been somewhere.
last_fixed(Result) -->
    { Result.status \== converged,
      fixed_hold(Result, Hold) },
    !,
    [ nl, '  the last pose that was fixed, at the hold point of ~w m:'-[Hold.range_m] ],
    pose_words(Hold.put(_{threshold_px:Result.threshold_px, merit_px:Hold.merit})),
    error_words(Hold).
last_fixed(_) -->
    [].

%   The last one.
fixed_hold(Result, Hold) :-
    reverse(Result.get(holds), Newest),
    member(Hold, Newest),
    Hold.status == fixed,
    !.

what_may_help(Result) -->
    { Helps = Result.get(advice) },
    !,
    { atomic_list_concat(Helps, '; ', Words) },
    [ nl, '  what may help: ~w'-[Words] ].
what_may_help(_) -->
    [].

help(Result, _, 'a seed pose, or [target] view, which tell which of the poses that fit is meant (--seed-pose)') :-
    several_poses(Result, _, _).
help(Result, images(Limit, Recorded), Help) :-
    (   Result.iterations < Recorded,
        limit_reached(Result, Limit)
    ->  counted(Limit, image, Images),
        format(atom(Help), "more than ~w (--max-iterations)", [Images])
    ;   rival_holds_back(Result)
    ->  Help = 'another view of the target: these images do not tell its pose from another one'
    ;   Result.iterations >= Recorded
    ->  counted(Recorded, frame, Frames),
        format(atom(Help), "a stack of more frames, or of frames under other lights: this one has ~w", [Frames])
    ;   Result.iterations > 0,
        \+ ( Controller = Result.get(controller), memberchk(Controller, [heuristic, informed]) ),
        Help = 'a strategy that goes on (--controller heuristic or informed)'
    ).
help(Result, _, 'is it the right model, and of the right size (--unit)? the report shows which lines are not there') :-
    is_dict(Result.pose),
    \+ rather_right(Result).
help(Result, _, Help) :-
    is_dict(Result.pose),
    rather_right(Result),
    merit_words(Result.merit_px, Merit),
    format(atom(Help), "a --threshold above ~w, where that is good enough", [Merit]).
help(Result, _, 'an end farther away (--contact-range)') :-
    fixed_hold(Result, _).

%   Of an approach, with both looks at its last hold point.
limit_reached(Result, Limit) :-
    last(Result.get(steps), Last),
    Hold = Last.get(hold),
    !,
    aggregate_all(count, ( member(Step, Result.steps), Step.get(hold) == Hold ), Images),
    Images >= 2 * Limit.
limit_reached(Result, Limit) :-
    Result.iterations >= Limit.

%   Why there is none: what a strategy leaves out or drops says nothing of the target.
without_pose(Result, _, 'a strategy that takes an image: this one took none') :-
    Result.iterations =:= 0,
    !.
without_pose(Result, _, 'a strategy that keeps an image which shows a pose: this one discarded all that did') :-
    findall(Decision, ( member(Step, Result.steps), _{pose:Pose, decision:Decision} :< Step, is_dict(Pose) ), Decisions),
    memberchk(discard, Decisions),
    \+ memberchk(keep, Decisions),
    !.
without_pose(_, Readings, 'light: every image is black where the target should be; is a lens cap on, do camera and lights work?') :-
    Readings = [_|_],
    forall(member(reading(_, statistics(_, Highlight, _, _, _)), Readings), black(Highlight)),
    !.
without_pose(Result, _, 'a strategy that decides on each image (keep_image, drop_image): this one left the last one open') :-
    length(Result.steps, Decided),
    Decided < Result.iterations,
    !.
without_pose(_, _, 'is the target in view, and its model of the right size (--unit)? --explain tells what was seen').

black(Highlight) :-
    first_grey(Grey),
    Highlight < Grey.

first_grey(0.004).                      % of 255, as a fraction of full scale

rival_holds_back(Result) :-
    is_dict(Result.pose),
    Result.iterations >= 3,             % as `spent` has it
    held_back(fix(_, _, quality(_, _, _, Result.score, Result.ambiguity), _), Result.threshold_px, _).

rather_right(Result) :-
    Result.score > 0.5.
