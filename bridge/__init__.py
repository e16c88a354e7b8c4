"""What the controller and the two servers say to each other, and how."""

__version__ = "0.1.0"
