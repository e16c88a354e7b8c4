"""Whether a plan's targets are as large as parts are."""

from pathlib import Path

from bridge.errors import BadInput
from experiments.plan import Plan
from geometry.errors import GeometryError
from geometry.model import load_model, size_meant


def unit_doubts(plan: Plan) -> list[str]:
    """What to say of target files whose size is likelier a wrong unit.

    Raises
    ------
    BadInput : a file that is no model.
    """
    units = {scene.source[0]: scene.unit for scene in plan.scenes if scene.target is not None}
    doubts = []
    for file, unit in units.items():
        if not Path(file).is_file():  # one of the project's
            continue
        try:
            across = load_model(file, unit).diameter
        except GeometryError as error:
            raise BadInput(f"{error}.") from None
        if not size_meant(across):
            doubts.append(f'{file} is {across:.3g} m across: can that be? A plan may say unit = "mm".')
    return doubts
