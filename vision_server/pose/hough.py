"""Where along each model line the image has one straight edge: Hough votes of all edge points.

A small error of the pose moves a straight line by an amount that is linear along it. Edge points of the true
edge agree on one such shift in every channel; texture, shadow edges and noise do not.
"""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats, Ints
from numerics.kernels import kernel

# Chosen by hand: courses are pairs of bins, so that finer bins take time by their square.
ALONG_BINS = 12  # of a line's length
BINS_PER_REACH = 10  # of the shift, to either side
SHIFT_BINS = 2 * BINS_PER_REACH + 1
# Chosen by hand: share of a channel's edge points that are weaker than its strong ones. An edge point that
# is so many times as strong as these counts half in its line's vote.
STRONG_SNR_RANK, HALF_QUALITY_SNR_RATIO = 0.8, 0.5
PRIOR_DROP = 0.4  # how much less a vote at the end of the reach counts: a pose is rather near than far off


def _courses() -> tuple[Ints, Floats]:
    """Courses that an edge may take beside a line, by the bins of its first and its last place.

    Returns
    -------
    The bin at each place, (S, S, A), S SHIFT_BINS and A ALONG_BINS; what votes for a course count, (S, S).
    """
    first, last = np.arange(SHIFT_BINS)[:, None, None], np.arange(SHIFT_BINS)[None, :, None]
    place = (np.arange(ALONG_BINS) + 0.5) / ALONG_BINS
    middle, tilt = 0.5 * (first + last) / BINS_PER_REACH - 1.0, 0.5 * (last - first) / BINS_PER_REACH
    share = 1.0 - PRIOR_DROP * np.minimum(1.0, middle**2 + tilt**2)
    return (first + (last - first) * place + 0.5).astype(np.int64), share[:, :, 0]


COURSE, VOTE_WORTH = _courses()
CHECKED_BINS = (4, 8)  # of a course, after which it is left when it cannot win any more
ROUNDING_SHARE = 1e-9  # share that sums in another order may differ by


@kernel()
def vote_worth(snr: Floats) -> Floats:
    """What each edge point counts in its line's vote, 0..1: strong beats weak, within its own channel."""
    channels, count, peaks = snr.shape
    out = np.zeros_like(snr)
    seen = np.empty(count * peaks)
    for c in range(channels):
        found = 0
        for i in range(count):
            for k in range(peaks):
                if snr[c, i, k] > 0.0:
                    seen[found] = snr[c, i, k]
                    found += 1
        if found == 0:
            continue
        rank = int(STRONG_SNR_RANK * (found - 1))
        strong = HALF_QUALITY_SNR_RATIO * np.partition(seen[:found], rank)[rank]
        for i in range(count):
            for k in range(peaks):
                out[c, i, k] = snr[c, i, k] / (snr[c, i, k] + strong)
    return out


@kernel()
def vote(
    line: Ints, along: Floats, offset: Floats, quality: Floats, lines: int, reach_px: float, width_px: Floats
) -> Floats:
    """Choose for each line the straight edge that most edge points lie on.

    Parameters
    ----------
    line, along
        (N,), the sample's line, of so many ``lines``, ascending, and its place on it from -1 to 1.
    offset, quality
        (C, N, K), edge points of C channels (NaN: none), and what each counts, 0..1.
    reach_px
        Votes are for shifts up to this.
    width_px
        (N,), tolerance of the vote of each sample's line.

    Returns
    -------
    shift (L, 2), px: offset at the line's middle, and its change from there to its end (at along = 1); 0 for
    lines without votes.
    """
    shift = np.zeros((lines, 2))
    table, rest = np.empty((ALONG_BINS, SHIFT_BINS)), np.empty(ALONG_BINS + 1)
    start = 0
    while start < len(line):
        end = start
        while end < len(line) and line[end] == line[start]:
            end += 1
        own = slice(start, end)
        width = width_px[start]
        _ballots(along[own], offset[:, own], quality[:, own], reach_px, width, table)
        first, last = _elected(table, rest)
        if first >= 0:
            shift[line[start], 0] = (0.5 * (first + last) / BINS_PER_REACH - 1.0) * reach_px
            shift[line[start], 1] = 0.5 * (last - first) / BINS_PER_REACH * reach_px
        start = end
    return shift


@kernel()
def _ballots(
    along: Floats, offset: Floats, quality: Floats, reach_px: float, width_px: float, table: Floats
) -> None:
    """Votes of one line by place and shift, (ALONG_BINS, SHIFT_BINS), output; parameters as in `vote`."""
    channels, count, peaks = offset.shape
    size = reach_px / BINS_PER_REACH
    width = max(width_px, size)
    table[:] = 0.0
    for c in range(channels):
        for i in range(count):
            b = min(ALONG_BINS - 1, int((along[i] + 1.0) * 0.5 * ALONG_BINS))
            for k in range(peaks):
                u = offset[c, i, k]
                if not abs(u) <= reach_px:
                    continue
                first = max(0, int(np.ceil((u - width) / size)) + BINS_PER_REACH)
                last = min(SHIFT_BINS - 1, int(np.floor((u + width) / size)) + BINS_PER_REACH)
                for j in range(first, last + 1):
                    distance = abs((j - BINS_PER_REACH) * size - u) / width
                    table[b, j] += quality[c, i, k] * (1.0 - distance)


@kernel()
def _elected(table: Floats, rest: Floats) -> tuple[int, int]:
    """First and last bin of the course with most votes (ALONG_BINS, SHIFT_BINS), (-1, -1) without any.

    A course is left early when it cannot reach what the best level course has any more; ``rest``
    (ALONG_BINS + 1,), output, are the most votes that one can get from a bin on.
    """
    rest[ALONG_BINS] = 0.0
    for b in range(ALONG_BINS - 1, -1, -1):
        most = 0.0
        for votes in table[b]:
            most = max(most, votes)
        rest[b] = rest[b + 1] + most
    least = 0.0
    for first in range(SHIFT_BINS):
        total = 0.0
        for b in range(ALONG_BINS):
            total += table[b, first]
        least = max(least, total * VOTE_WORTH[first, first])
    least *= 1.0 - ROUNDING_SHARE
    best, elected = 0.0, (-1, -1)
    for first in range(SHIFT_BINS):
        for last in range(SHIFT_BINS):
            counts, total = VOTE_WORTH[first, last], 0.0
            if rest[0] * counts < least:
                continue
            for b in range(ALONG_BINS):
                if b in CHECKED_BINS and (total + rest[b]) * counts < least:
                    break
                total += table[b, COURSE[first, last, b]]
            if total * counts > best:
                best, elected = total * counts, (first, last)
    return elected


@kernel()
def choose(line: Ints, along: Floats, offset: Floats, shift: Floats, width_px: Floats) -> Ints:
    """Which edge point of each channel and sample is nearest to its line's edge, (C, N), -1 for none.

    Parameters as in `vote`, and the ``shift`` that it returns.
    """
    channels, count, peaks = offset.shape
    chosen = np.full((channels, count), -1)
    for c in range(channels):
        for i in range(count):
            expected = shift[line[i], 0] + shift[line[i], 1] * along[i]
            nearest = 1.5 * width_px[i]
            for k in range(peaks):
                distance = abs(offset[c, i, k] - expected)
                if distance < nearest:
                    nearest, chosen[c, i] = distance, k
    return chosen
