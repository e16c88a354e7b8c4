"""The lines that benchmarks print: one JSON object for each thing measured."""

import json
from typing import Protocol


class Show(Protocol):
    """Where a result goes: name, value, unit, and what else is to be said."""

    def __call__(self, name: str, value: float, unit: str, **more: object) -> None: ...


def show(name: str, value: float, unit: str, **more: object) -> None:
    """Print one measurement, its numbers to four places."""
    said = {key: round(other, 4) if isinstance(other, float) else other for key, other in more.items()}
    print(json.dumps({"name": name, "value": round(value, 4), "unit": unit, **said}), flush=True)
