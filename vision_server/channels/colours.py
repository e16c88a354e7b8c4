"""What may be taken of a colour image: its luma, one of its bands, or each band as an image of its own."""

BANDS = ("blue", "green", "red")  # as OpenCV orders them
ONE = ("grey", *reversed(BANDS))
COLOURS = (*ONE, "each")
