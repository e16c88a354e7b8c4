"""What the project's own ways are compared with; each stays selectable.

`merge_rules`: other rules that make one edge map of several images (`--method mean`, `max-image`, …).
`linking`, `splitting`: the paper's grouping of edgels (`extract_segments(grouping="splitting")`).
`genetic`: the paper's matcher (`--matcher genetic`).
"""
