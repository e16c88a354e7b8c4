"""From candidate poses to one refined pose, its covariance, and how far it can be trusted."""
