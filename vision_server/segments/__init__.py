"""Straight segments of an edge map: `extraction` is the way of all of it.

`growing` follows edgels in a line, `line_fit` says where it lies and whether it is there by chance, `joining`
and `bending` put lines together and cut them; `curves` are the short pieces of bent edges.
"""
