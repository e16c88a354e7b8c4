"""What images under other settings would show of a pose, line by line.

`response` learns how bright both sides of each line are under each light, from what is known before (`prior`,
`lit_target`) and what images have shown at the target's `places`; `straying` learns what is not noise.
`information` and `belief` say what an image would add, `search` looks for settings that add most.

An image that is not as foreseen: `target_moved` (has the target moved?), `causes` (what else has happened),
`hidden` and `new_edges` (is something in the way?), `repeated` (two pictures of the same settings).
"""
