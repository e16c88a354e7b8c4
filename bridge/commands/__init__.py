"""Commands of `python -m bridge`, one file each."""
