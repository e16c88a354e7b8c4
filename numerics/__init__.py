"""What compiled kernels of every room share: the decorator, small solvers, two cores, kept memory."""
