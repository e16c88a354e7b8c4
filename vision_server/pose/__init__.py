"""From a pose that is nearly right to the one that the edges of all channels give, and its covariance.

One refinement (`refinement`) repeats: where the visible lines are (`sampling`, `along_lines`) and what the
images show along them (`observation`), which edge points are theirs (`edge_points`, `association`, `hough`),
what these count (`weights`, `line_scales`), the step (`solver`, `steps`). `courses` puts the edge points of a
line together, for the last step (`vision_server.trust.settling`); `covariance` says how exact a pose is by
what its lines leave.

What draws an edge away from its line is each in a file of its own: `blending` (edges beside each other),
`curved_edges`, `roundings` (edges that are not sharp), `outline_shading` and `outline_profiles` (outlines of
smooth surfaces), `profiles`. Which of many poses is the right one, and how surely, is asked in
`vision_server.trust`.
"""
