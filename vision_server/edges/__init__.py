"""All images of a set, merged into one edge map (the paper, "multi-channel edge detection").

`mixture` is EM over the orientations at one pixel: its definition, then its kernel. `merging` puts the
channels together, first at one pixel as the paper has it, then for the whole image; `ridges` thins what comes
of it, with the mixture's share there. `suppression` is Canny's way with one gradient image, `edge_map` the
list of edgels that both make. `moved` says whether the images show one scene at all. What kind an edge is:
`vision_server.kinds`.
"""
