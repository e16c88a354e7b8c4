"""Command lines of experiments, one file each."""
