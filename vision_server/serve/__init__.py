"""The vision server: sessions behind the wire protocol.

`server` answers the operations, `sessions` has one `task` for each client. `opening` makes it of what `start`
gives: `inputs`, `described` and `camera_files` read model, camera and seed pose, `files` says which may be
named, `parameters` what a controller may set. `taking` is a frame into the set, with its `statistics`, kept
by `recorder`; `prediction` and `surprises` are what is foreseen of it, `tracking` frames of a moving target.

`results` are estimates as plain values; `verification` and `witnesses` hold poses of others against images.
"""
