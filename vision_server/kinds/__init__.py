"""What kind each edge is: outline, crease, print, shadow or highlight, by how it answers to the lights.

`kinds` states the model and fits it by EM; `likelihoods` has the density of each kind; what these look at is
in `sides` (what channels show on both sides of an edgel), `densities` and `scatter`. `background` and
`ground` say what is behind, `fading` which contours end in the dark.

Lights: `light_parts` takes the channels apart where levels are known; `learnt_lights`, `together`, `alone`
and `dark_room` learn them where nobody told. `each_light` and `blocked` look for a light that is blocked on
one side, `falling` for the side to which its shadows fall. `along` makes neighbours on one edge of one kind;
`kinds_table` is what other programs and people get.
"""
