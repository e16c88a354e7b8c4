"""Every frame of a moving target, and whether a pose from elsewhere is right.

*A frame*: `tracker` says in which order a frame is looked at; `following` looks near where the target is
expected, `searching` around a pose or everywhere. `acceptance` has the rules by which a pose is followed,
believed and sure; `tracker` asks for them, and for what else has to hold: `narrow` faces, `round_parts`,
`rivals`, `turning` (how far it can have turned) and `strain` (a model that is too long).

*A pose in it*: `frame` makes the problem of one frame, `lines` say where each line lies, `fitting` puts them
together. `beside`, `outermost` and `repeated_lines` are about which edges are the target's; `softness` about
their blur.

*From frame to frame*: `motion` (the filter), `history`, `usual` (what each light shows), `clock`.

`sources` and `served_frames` are where frames come from, `tracked` is what is told of one. `referee` judges
poses of other programs, by the probability of `chances`.
"""
