"""What images under other settings would show of a pose, line by line."""
