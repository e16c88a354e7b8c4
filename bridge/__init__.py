"""What the controller and the two servers say to each other, and how."""
