"""Shading, fall-off, beams and shadows as an independent ray tracer has them, where it is installed."""

import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks import povray
from benchmarks.validation import CHALK, SUN
from geometry.camera import Camera
from geometry.model import TARGETS, load_model
from geometry.pose import Pose
from image_server.simulator.light import (
    LIGHT_AT_REFERENCE,
    REFERENCE_DISTANCE_M,
    SUN_STRENGTH,
    Illumination,
    beam_table,
)
from image_server.simulator.material import load_appearance
from image_server.simulator.scenario_tables import Light
from image_server.simulator.scene import joined, target_part
from image_server.simulator.sky import Sky
from image_server.simulator.tracing import traced

pytestmark = pytest.mark.slow

CAMERA = Camera(160, 120, 200.0, 200.0, 79.5, 59.5)
POSE = Pose(np.array([0.4, 0.5, 0.1]), np.array([0.0, 0.0, 0.6]))
LAMP = Light(name="led", position=(0.3, -0.1, 0.0), aim=(-0.3, 0.1, 0.6), half_intensity_deg=20.0)


@pytest.mark.skipif(not povray.available(), reason="POV-Ray (Debian package povray) is not installed")
@pytest.mark.parametrize("lamp", [LAMP, None], ids=["lamp", "sun"])
def test_both_ray_tracers_see_the_same(tmp_path: Path, lamp: Light | None) -> None:
    file = TARGETS / "fixture.cao"
    model = load_model(file)
    scene = joined([target_part(model, load_appearance(file, len(model.faces)), CHALK, POSE)])
    aim = np.array(LAMP.aim)
    sky = Sky(SUN, 0.0, SUN_STRENGTH)
    light = Illumination(
        np.array([LAMP.position]), aim[None] / np.linalg.norm(aim), beam_table(LAMP)[None], sky
    )
    if lamp is None:
        theirs_light = povray.far_light(SUN, SUN_STRENGTH)
    else:
        power = math.log(0.5) / math.log(math.cos(math.radians(20.0)))
        strength = LIGHT_AT_REFERENCE * REFERENCE_DISTANCE_M**2
        theirs_light = povray.point_light(np.array(lamp.position), strength, aim, power)
    ours = traced(scene, CAMERA, light).images[1 if lamp is None else 0]
    theirs = povray.rendered(scene, CAMERA, [theirs_light], 3, tmp_path)
    difference = np.abs(ours - theirs)[theirs > 0] / theirs.max()
    assert (theirs > 0).mean() > 0.1
    assert np.quantile(difference, 0.7) < 5e-4  # inside the faces
    assert np.sqrt((difference**2).mean()) < 0.05  # edges take samples
    assert abs(float(ours.sum() / theirs.sum()) - 1) < 2e-3
