"""`simulator`: serve a ray-traced target."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from bridge.command_line import add_serving
from image_server.commands.options import (
    AS_IN_THE_FILE,
    Conditions,
    add_conditions,
    add_deaths,
    add_events,
    add_past,
    add_seed,
    add_target,
    given_conditions,
    with_deaths,
)
from image_server.commands.serving import serve_device

if TYPE_CHECKING:
    from image_server.simulator.simulator import Simulator


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    add_serving(parser)
    add_events(parser)
    add_scene(parser)
    add_seed(parser)
    add_past(parser)
    add_conditions(parser)
    add_deaths(parser)


def add_scene(parser: ArgumentParser) -> None:
    """What the simulator shows."""
    add_target(parser, "cube")
    parser.add_argument(
        "--scenario",
        default="nominal",
        metavar="NAME_OR_FILE",
        help="A scenario of scenarios/ or a TOML file (default: %(default)s).",
    )


def run(options: Namespace) -> int:
    """Serve until told to stop; the exit status."""
    return serve_device(
        lambda: with_deaths(simulated_device(options, given_conditions(options)), options), options
    )


def simulated_device(options: Namespace, conditions: Conditions = AS_IN_THE_FILE) -> Simulator:
    """The simulator of a scene under other conditions."""
    from bridge.image_messages import MoveDone
    from image_server.simulator.scenario import load_scenario, with_conditions
    from image_server.simulator.simulator import Simulator

    scenario = with_conditions(load_scenario(options.scenario), *conditions)
    return Simulator(
        options.target or "cube",
        scenario,
        options.seed,
        unit=options.unit,
        captures_taken=options.captures_taken,
        moves=[MoveDone(range_m=range_m, captures_taken=taken) for range_m, taken in options.moved],
    )
