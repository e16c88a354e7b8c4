"""Memory of processes that compute: what is freed is kept, and garbage is looked for rarely."""

from __future__ import annotations

import gc

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_ARENA_MAX = -1, -3, -8  # of mallopt(3)
KEPT_BYTES = 1 << 28  # free at the end of the heap, before any of it is given back
LARGEST_BYTES = 1 << 23  # of an array that comes from the heap: larger ones would leave holes in it
OBJECTS_BETWEEN_COLLECTIONS = 300_000  # a start and a first pose make 207 000 that stay, a later session 30


def keep_freed_memory() -> None:
    """Have the C library keep what is freed instead of giving it back to the system at once.

    The arrays of one image are those of the next. A page that was given back comes as a page fault, and an
    edge map of four images has 1500 of them: a third of its time. Does nothing where the C library is not
    glibc.
    """
    import ctypes  # late: who only collects rarely need not load it

    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(M_TRIM_THRESHOLD, KEPT_BYTES)
        mallopt(M_MMAP_THRESHOLD, LARGEST_BYTES)
        mallopt(M_ARENA_MAX, 1)  # arrays of every thread: others keep less, and not for each other


def collect_rarely() -> None:
    """Have Python look for garbage less often: what a start loads stays, and is looked through in vain."""
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)
