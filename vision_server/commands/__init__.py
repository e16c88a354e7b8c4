"""Command lines of the vision server, one file each."""
