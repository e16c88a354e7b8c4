"""All images of a set, merged into one edge map (the paper, "multi-channel edge detection")."""
