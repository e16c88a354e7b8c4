"""A seed pose from pairs of points: a corner of the model, and where it is in the image."""
