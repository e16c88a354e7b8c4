"""Measurements, each a command (docs/validation.md); linear algebra on one thread, as in the servers."""

from numerics.blas import use_one_blas_thread

use_one_blas_thread()
