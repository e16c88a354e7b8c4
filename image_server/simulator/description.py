"""What `describe` says of a simulated scene; never the true pose."""

from pathlib import Path

import msgspec

from bridge.messages import Describe, LightDescription, PoseMessage, TargetDescription
from geometry.camera import Camera
from geometry.pose import Pose
from image_server.simulator.scenario_tables import Scenario


def described(
    name: str,
    scenario: Scenario,
    camera: Camera,
    model: Path,
    unit: str,
    seed_pose: Pose | None,
    nearest_m: float,
) -> Describe:
    """Settings of the scenario, camera at the focal length in use, target and seed pose.

    Parameters
    ----------
    name : of the device.
    model, unit : the target's file, and the unit of its numbers.
    seed_pose : where the target is said to be; None where nothing is said.
    nearest_m : range that it can be brought to.
    """
    return Describe(
        device=name,
        lights=tuple(
            LightDescription(
                name=light.name,
                levels=light.levels,
                position=light.position,
                power=light.power * scenario.light_power,
            )
            for light in scenario.lights
        ),
        shutters_s=scenario.camera.shutters_s,
        apertures=scenario.camera.apertures,
        focal_lengths_mm=scenario.camera.focal_lengths_mm,
        focuses_m=scenario.camera.focuses_m,
        camera=msgspec.structs.replace(scenario.camera.description(), fx=camera.fx, fy=camera.fy),
        target=TargetDescription(
            model=str(model),
            unit=unit,  # type: ignore[arg-type]  # load_model has checked it
            seed_pose=None if seed_pose is None else pose_message(seed_pose),
            tolerance_m=0.0,  # what is drawn is the model
        ),
        movable=True,
        nearest_m=nearest_m,
    )


def pose_message(pose: Pose) -> PoseMessage:
    """A pose as messages carry it."""
    return msgspec.convert(pose.to_dict(), PoseMessage)
