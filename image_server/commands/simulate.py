"""`simulator`: serve a ray-traced target."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from image_server.command_line import Option
from image_server.commands.options import Conditions, Draws, Serving
from image_server.commands.serving import serve_device
from numerics.kernels import prepare_kernels, use_library

if TYPE_CHECKING:
    from image_server.simulator import Simulator


@dataclass(frozen=True, kw_only=True)
class Scene:
    """What the simulator shows."""

    target: Annotated[
        str,
        Option(metavar="NAME_OR_FILE", help="A target of targets/ or a .cao, OBJ, STL or PLY file."),
    ] = "cube"
    scenario: Annotated[
        str, Option(metavar="NAME_OR_FILE", help="A scenario of scenarios/ or a TOML file.")
    ] = "nominal"
    unit: Annotated[str, Option(help="Unit of the model file: m, cm, mm or in.")] = "m"


def simulator(serving: Serving, scene: Scene, draws: Draws, conditions: Conditions) -> None:
    """Serve a ray-traced target under lights and a sun; the seed draws its true pose."""
    use_library("image_server")
    serve_device(lambda: simulated_device(scene, draws, conditions), serving)


def simulated_device(scene: Scene, draws: Draws, conditions: Conditions) -> "Simulator":
    """The simulator of a scene under other conditions."""
    from image_server.simulator import Simulator
    from image_server.simulator.scenario import load_scenario, with_conditions

    prepare_kernels()
    described = with_conditions(load_scenario(scene.scenario), *conditions.values())
    return Simulator(
        scene.target, described, draws.seed, unit=scene.unit, captures_taken=draws.captures_taken
    )
