"""Scales of the plots: from values to places on the page, and the ticks between."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

LOG_FROM = 15.0  # values that spread over more than this factor are drawn on a logarithmic scale
FEW_DECADES = 300.0  # a logarithmic scale over less than this factor has ticks at 1, 2 and 5


@dataclass(frozen=True)
class Axis:
    """A linear or logarithmic scale from values `low`–`high` to places `start`–`end`."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def at(self, value: float) -> float:
        """Place of a value."""
        if self.log:
            share = math.log(max(value, self.low) / self.low) / math.log(self.high / self.low)
        else:
            share = (value - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        """Round values along the scale, three to seven of them where that is possible."""
        if not self.log:
            step = _round_step((self.high - self.low) / 4)
            first = math.ceil(self.low / step - 1e-9)
            return [number * step for number in range(first, math.floor(self.high / step + 1e-9) + 1)]
        decades = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
        digits = (1, 2, 5) if self.high / self.low < FEW_DECADES else (1,)
        values = [float(f"{digit}e{decade}") for decade in decades for digit in digits]
        return [value for value in values if self.low * 0.999 <= value <= self.high * 1.001]


def fitted(values: Sequence[float], start: float, end: float, log: bool | None = None) -> Axis:
    """An axis that holds all values, from zero unless it is logarithmic.

    `log` None chooses by the values' spread; zero or negative values rule a logarithmic scale out.
    """
    finite = [value for value in values if math.isfinite(value)] or [1.0]
    low, high = min(finite), max(finite)
    if log is None:
        log = low > 0 and high / low > LOG_FROM
    if log and low > 0:
        return Axis(low / 1.35, high * 1.35, start, end, True)
    top = high if high > 0 else 1.0
    return Axis(min(0.0, low), top * 1.08, start, end)


def _round_step(rough: float) -> float:
    decade = 10.0 ** math.floor(math.log10(rough))
    return next(digit * decade for digit in (1, 2, 5, 10) if digit * decade >= rough * 0.999)
