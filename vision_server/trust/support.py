"""How well the images support a pose: per-line errors, and an RMS that losing lines cannot lower.

In goes an observation; out come which samples of visible lines have an edge, and the evidence of that: a log
likelihood ratio, of lines that are there over edges that lie beside them by chance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Flags, Floats
from numerics.kernels import kernel
from vision_server.pose.observation import Observation, PoseProblem, observe
from vision_server.pose.weights import line_trust
from vision_server.trust.coincident import Told, told_once
from vision_server.trust.hidden_together import NOT_SEEN_NATS, evidence_of

# Chosen by hand where nothing else is said. Halved or doubled (`python -m benchmarks.constants`, 24 sets of
# recorded and hard stacks), cap and reach of support change at most two poses from right to wrong or back.
CAP_PX = 4.0  # distance that a part of a visible line without support counts with
SUPPORT_PX = 1.0  # a part has support when its edge point is this close (times sqrt of the filter's scale)
LEAST_TRUST = 0.02  # of a line in a channel, for its edge points to be support
NORMAL_FLOOR_PX = 0.1  # RMS below this says nothing more
# What a line's support is evidence of: a run of a true line has support with the one probability, a run
# beside which there are edges by chance with the other. A fit of the trust hardly depends on these four.
SEEN, BY_CHANCE = 0.92, 0.2
# In a row of lines so far apart an edge is within SUPPORT_PX of any place by that chance; nearer, by more.
CROWDED_PX = 2.0 * SUPPORT_PX / BY_CHANCE
RUN_PX, MOST_RUNS = 10.0, 4.0  # neighbours have support together; a longer line is on clutter or is not
MISSING_SUPPORT = 0.3  # of its length: a line with less support is missing


@dataclass(frozen=True)
class LineSupport:
    """What the images say about one visible model line.

    Attributes
    ----------
    line
        Index into the model's lines.
    visible_px
        Length of its visible parts in the image.
    support
        Share of that length with an edge close to it, 0..1.
    rms_px
        Root mean square distance to the edges; parts without support count CAP_PX.
    image
        The channel that supports it most, None without support.
    """

    line: int
    visible_px: float
    support: float
    rms_px: float
    image: str | None


@dataclass(frozen=True, eq=False)
class PoseSupport:
    """How well the images support a whole pose; N samples, C channels of these names, L model lines.

    Attributes
    ----------
    rms_px
        Over the visible length of all lines, parts without support at CAP_PX.
    supported_fraction
        Share of the visible length that is supported.
    strength
        Mean over the visible length of (1 - d / CAP_PX), from 0 to 1.
    clipped_fraction
        Share of the visible length that only edges beside saturated pixels support.
    names
        Of the channels.
    samples
        Points on the visible lines.
    distance
        (N,) px, from the nearest edge point of any channel, at most CAP_PX.
    supports
        (C, N), whether a channel's edge point supports the sample.
    trust
        (C, L), see `line_trust`.
    slack
        (N,) px, see `Observation`.
    """

    rms_px: float
    supported_fraction: float
    strength: float
    clipped_fraction: float
    names: Sequence[str]
    samples: Samples
    distance: Floats
    supports: Flags
    trust: Floats
    slack: Floats

    @cached_property
    def by_line(self) -> tuple[Floats, Floats]:
        """Visible and supported length of each line, (L,) px."""
        line, px, count = self.samples.line, self.samples.px, self.trust.shape[1]
        visible = np.asarray(np.bincount(line, px, count), dtype=np.float64)
        seen = np.bincount(line, px * self.supports.any(axis=0), count)
        return visible, np.asarray(seen, dtype=np.float64)

    @cached_property
    def _told(self) -> Told:
        """What the samples tell, those that fall together with an earlier line's but once."""
        supported = np.asarray(self.supports.any(axis=0))
        return told_once(self.samples, supported, CROWDED_PX)

    def _by_own(self, amount: Floats | Flags) -> Floats:
        """Sum of an amount (N,) per px over the samples of each line that stand for themselves, (L,)."""
        weights = self.samples.px * self._told.own * amount
        return np.asarray(np.bincount(self.samples.line, weights, self.trust.shape[1]), dtype=np.float64)

    @cached_property
    def _visible(self) -> Floats:
        """Length of each line on samples that stand for themselves, (L,), px."""
        return self._by_own(np.ones(len(self.samples.px)))

    @cached_property
    def _evidence(self) -> Floats:
        """Of each visible line, nats: log likelihood of its support if it is there over that by chance.

        Less where a crease is rounded: of so many parallels any may be its edge, one by chance.
        """
        told = self._told
        chance = np.clip(2.0 * SUPPORT_PX / told.gap, BY_CHANCE, SEEN)
        nats = np.where(told.seen, np.log(SEEN / chance), np.log((1.0 - SEEN) / (1.0 - chance)))
        visible = self._visible
        there = visible > 0
        runs = np.minimum(visible[there] / RUN_PX, MOST_RUNS)
        slack = self._by_own(self.slack)[there] / visible[there]
        return np.asarray(runs * self._by_own(nats)[there] / visible[there] - np.log1p(slack / SUPPORT_PX))

    @property
    def confirmed(self) -> float:
        """Evidence of the lines that speak for the pose, nats."""
        return float(np.maximum(self._evidence, 0.0).sum())

    @property
    def evidence(self) -> float:
        """Log likelihood of all lines, nats, over that of chance: one that is not seen may be hidden."""
        return float(np.maximum(self._evidence, -NOT_SEEN_NATS).sum())

    @property
    def evidence_together(self) -> float:
        """The same, where what hides one line hides those beside it, too, see `hidden_together`.

        For poses that show a target from different sides, of which one shows many small parts of it: that
        these are not seen, as they are as grey as what they stand on, is one cause.
        """
        return self.evidence_of(np.ones(self.trust.shape[1], dtype=np.bool_), together=True)

    def evidence_of(self, lines: Flags, together: bool) -> float:
        """`evidence` or `evidence_together` of some of the lines, (L,)."""
        there = self._visible > 0
        chosen = lines[there]
        if not together:
            return float(np.maximum(self._evidence[chosen], -NOT_SEEN_NATS).sum())
        line, px, count = self.samples.line, self.samples.px, self.trust.shape[1]
        weight = np.bincount(line, px, count)[there]
        middle = [np.bincount(line, px * self.samples.image[:, axis], count)[there] for axis in (0, 1)]
        return evidence_of(self._evidence[chosen], (np.column_stack(middle) / weight[:, None])[chosen])

    @property
    def missing(self) -> float:
        """Share of the visible length that is of lines with support of less than MISSING_SUPPORT."""
        visible, supported = self._visible, self._by_own(self._told.seen)
        return float(visible[supported < MISSING_SUPPORT * visible].sum() / visible.sum())

    @property
    def shares(self) -> dict[int, float]:
        """Share of each visible line that is supported, as `LineSupport.support`."""
        visible, supported = self.by_line
        there = np.flatnonzero(visible)
        return dict(
            zip(there.tolist(), np.minimum(1.0, supported[there] / visible[there]).tolist(), strict=True)
        )

    @cached_property
    def lines(self) -> tuple[LineSupport, ...]:
        """Support of each visible line; of the many poses that are looked at, few are asked for it."""
        line, px, count = self.samples.line, self.samples.px, self.trust.shape[1]
        visible = self.by_line[0]
        squares = np.bincount(line, px * self.distance**2, count)
        by_channel = np.stack([np.bincount(line, px * seen, count) for seen in self.supports])
        most = np.argmax(by_channel * self.trust, axis=0)
        return tuple(
            LineSupport(
                line=index,
                visible_px=float(visible[index]),
                support=share,
                rms_px=math.sqrt(squares[index] / visible[index]),
                image=self.names[most[index]] if by_channel[most[index], index] > 0 else None,
            )
            for index, share in self.shares.items()
        )


def support_at(problem: PoseProblem, pose: Pose, spacing_px: float, pulls: bool = True) -> PoseSupport | None:
    """Look for the support of a pose; None when no line of the model is visible from it.

    Whether edges are moved back by what ``pulls`` at them, see `observe`.
    """
    seen = observe(problem, pose, CAP_PX, spacing_px, pulls)
    if len(seen.along) == 0:
        return None
    return support_of(seen, [channel.name for channel in problem.channels])


def evidence_at(problem: PoseProblem, pose: Pose, spacing_px: float) -> float:
    """`evidence_together` of a pose; -inf when no line of the model is visible from it."""
    support = support_at(problem, pose, spacing_px)
    return -math.inf if support is None else support.evidence_together


def support_of(seen: Observation, names: Sequence[str]) -> PoseSupport:
    """The support that an observation speaks of; ``names`` of its channels."""
    line, px = seen.samples.line, seen.samples.px
    trust = line_trust(seen)
    near = np.abs(_from_own_edge(seen) if seen.slack.any() else seen.offset)
    usable = np.isfinite(near) & (trust[:, line] >= LEAST_TRUST)
    near = np.where(usable, np.minimum(near, CAP_PX), CAP_PX)
    distance = near.min(axis=0)
    supports = usable & (near <= SUPPORT_PX * np.sqrt(seen.sigma[:, line]))
    supported = supports.any(axis=0)
    clean = (supports & (seen.nuisance[:, :, 1] == 0.0)).any(axis=0)
    total = float(px.sum())
    return PoseSupport(
        rms_px=float(np.sqrt((px @ distance**2) / total)),
        supported_fraction=min(1.0, float((px * supported).sum()) / total),
        strength=float(px @ (1.0 - distance / CAP_PX)) / total,
        clipped_fraction=float((px * (supported & ~clean)).sum()) / total,
        names=names,
        samples=seen.samples,
        distance=distance,
        supports=supports,
        trust=trust,
        slack=seen.slack,
    )


@kernel()
def _from_own_edge(seen: Observation) -> Floats:
    """Offsets (C, N), of rounded creases from an edge of their own: the median, not beyond the rounding."""
    out, line = seen.offset.copy(), seen.samples.line
    start = 0
    while start < len(line):
        end = start
        while end < len(line) and line[end] == line[start]:
            end += 1
        slack = seen.slack[start:end].mean()
        for c in range(len(out)):
            own = out[c, start:end]
            known = own[np.isfinite(own)]
            if slack > 0.0 and len(known) > 0:
                own -= min(max(float(np.median(known)), -slack), slack)
        start = end
    return out
