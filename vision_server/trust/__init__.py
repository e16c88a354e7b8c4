"""Which of many poses is the right one, and how far it can be trusted.

The way of an estimate, with what each step makes of a pose (`vision_server.pipeline` is the caller):

1. The matcher's hypotheses are refined coarsely and the best of them to the end: `ranking.best_first` with a
   seed pose, `all_sides.of_most_evidence` at first sight. Both also try what a small step does not lead to:
   turns about the axis of a round part (`spun`), near symmetries, and poses beside (`hypotheses`). Each makes
   a `Refined`, by `vision_server.pose.refinement` and by how the images support it (`support`).
2. Which of them goes first: `rivals.likeliest_first` with a seed pose; at first sight `likely`, by what the
   last step makes of each.
3. The last step (`settling`): lines as wholes (`pose.courses`), most off by little and a few by much. It
   makes a `Settled`, with the covariance and its `tails`, and how well the lines agree. Tracking fits whole
   lines in its own way, as each frame has the lines of those before: `vision_server.tracking.fitting`.
4. Rivals: `rivals` of the pose, turns of it by what alone tells these from it (`told_apart`); `alternatives`
   for all poses that a first sight tells.
5. `judgement` puts together what is said. `stretch` and `other_hand` measure how much better another model
   does, `restarts` whether the pose is the only one near by; `probability` decides what that is worth, and
   how sure the pose is. It makes the `Estimate`.

`support` is of the lines that are seen: `coincident` ones are one, and what hides one hides those beside it
(`hidden_together`). `equal_parts` tells poses at different places of an image apart.
`roundness` says whether a part has its model's facets.

What says how good a pose is, from the plainest to what is told:

==========================  =========================  =====================================================
``strength``                0 to 1, of `support`       how near edges are to the visible lines, in the mean
``supported_fraction``      0 to 1, of `support`       share of the visible length with an edge on it
``rms_px``                  px, of `support`           distance to the edges, where there is none CAP_PX
``quality``                 1/px, of `probability`     these three in one: ranks poses around a seed pose
``evidence``                nats, of `support`         log likelihood of all lines over chance: weighs rivals
``evidence_together``       nats, of `support`         the same, lines that are hidden together counted once:
                                                       compares poses that show different sides
``confirmed``, ``missing``  of `support`               nats of the lines that speak for a pose, and the
                                                       share of the visible length that is not seen
``LineAgreement``           by `settling`              lines that lie where the last step has them, and their
                                                       scatter
``Misfit``                  by `stretch`               how much better a stretched or mirrored model does
``ambiguity``               0 to 1, of `probability`   chance of the likeliest other pose over this one
``belief``                  0 to 1, of `probability`   from these: that the pose is the right one, however
                                                       exact
``confidence``              0 to 1, of `probability`   ``belief``, and that it is exact enough: the score
``probability``             0 to 1, of `likely`        of each pose of a first sight: its share of the
                                                       evidence, times ``confidence``
==========================  =========================  =====================================================

How much of these makes a pose sure is decided elsewhere: of a session by `domain/reasoning/merit.pl`, with
the same limit in `pipeline.SURE_SCORE`; of a frame by `tracking.acceptance`; of a pose from elsewhere by
`tracking.referee`.
"""
