"""Every frame of a moving target, and whether a pose from elsewhere is right."""
