"""The traced images obey physics: light falls as it must, shadows lie where they belong, edges are true."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.pose import Pose
from image_server.simulator import texture, tracing
from image_server.simulator.light import (
    LIGHT_AT_REFERENCE,
    ROWS,
    SUN_STRENGTH,
    Illumination,
    beam_table,
)
from image_server.simulator.material import Appearance, Material, MaterialChanges
from image_server.simulator.scenario_tables import Light
from image_server.simulator.scene import Scene, joined, target_part
from image_server.simulator.shading import microfacets
from image_server.simulator.sky import Sky
from image_server.simulator.tracing import traced
from numerics.arrays import Field, Floats

CAMERA = Camera(320, 240, 400.0, 400.0, 159.5, 119.5)
CHALK = Material(albedo=0.6, texture="plain", grain=0.0, specular=0.0)
ALONG_AXIS = np.array([0.0, 0.0, -1.0])


def quad(folder: Path, name: str, corners: list[tuple[float, float, float]]) -> Model:
    """A model of quadrilaterals, four corners each."""
    faces = [" ".join(str(4 * f + k) for k in range(4)) for f in range(len(corners) // 4)]
    lines = ["V1", str(len(corners)), *(" ".join(map(str, c)) for c in corners), "0", "0", str(len(faces))]
    file = folder / f"{name}.cao"
    file.write_text("\n".join([*lines, *(f"4 {face}" for face in faces), "0", "0", ""]))
    return load_model(file)


def scene_of(model: Model, pose: Pose, material: Material = CHALK) -> Scene:
    return joined([target_part(model, Appearance(material=material), MaterialChanges(), pose)])


def at(
    depth: float, turn: tuple[float, float, float] = (0.0, 0.0, 0.0), x: float = 0.0, y: float = 0.0
) -> Pose:
    return Pose(np.array(turn), np.array([x, y, depth]))


def lit(*lights: tuple[float, float, float], sun: Floats = ALONG_AXIS, disc: float = 0.0) -> Illumination:
    beams = np.ones((len(lights), ROWS))
    aims = np.tile([0.0, 0.0, 1.0], (len(lights), 1))
    return Illumination(np.array(lights), aims, beams, Sky(np.asarray(sun), disc, SUN_STRENGTH))


def images_of(scene: Scene, light: Illumination) -> list[Field]:
    return traced(scene, CAMERA, light).images


@pytest.fixture
def square(tmp_path: Path) -> Model:
    """A square of 0.2 m in the plane z = 0."""
    return quad(tmp_path, "square", [(-0.1, -0.1, 0), (0.1, -0.1, 0), (0.1, 0.1, 0), (-0.1, 0.1, 0)])


def middle(image: Field) -> float:
    return float(image[119:121, 159:161].mean())


def test_a_light_falls_with_the_square_of_its_distance(square: Model) -> None:
    light = lit((0.0, 0.0, 0.0))
    found = [middle(images_of(scene_of(square, at(z)), light)[0]) for z in (0.3, 0.6, 1.2)]
    assert found == pytest.approx([LIGHT_AT_REFERENCE * 0.6 * k for k in (4.0, 1.0, 0.25)], rel=1e-3)


@pytest.mark.slow
def test_the_sun_does_not_fall_with_distance_and_follows_the_cosine(square: Model) -> None:
    for depth in (0.4, 1.0):
        for angle in (0.0, 0.5, 1.2):
            sun = np.array([math.sin(angle), 0.0, -math.cos(angle)])
            image = images_of(scene_of(square, at(depth)), lit((0, 0, 0), sun=sun))[-1]
            assert middle(image) == pytest.approx(SUN_STRENGTH * 0.6 * math.cos(angle), rel=1e-3)


def test_a_light_behind_a_face_does_not_reach_it(square: Model) -> None:
    images = images_of(scene_of(square, at(0.6)), lit((0, 0, 1.2), sun=np.array([0.0, 0.0, 1.0])))
    assert all(image.max() == 0 for image in images)


def test_several_lights_are_what_each_is_alone(square: Model) -> None:
    scene = scene_of(square, at(0.6, (0.4, -0.3, 0.1)))
    left, right = (-0.35, 0.0, 0.0), (0.35, 0.1, 0.0)
    both = images_of(scene, lit(left, right))
    for image, light in zip(both, (left, right), strict=False):
        alone = images_of(scene, lit(light))[0]
        assert image == pytest.approx(alone, abs=2e-3 * float(alone.max()))


@pytest.mark.parametrize("shift_px", [0.0, 0.13, 0.37, 0.5, 0.77])
@pytest.mark.parametrize("roll", [0.0, 0.2])
def test_a_silhouette_lies_where_it_should_to_a_fraction_of_a_pixel(
    square: Model, shift_px: float, roll: float
) -> None:
    pose = at(0.6, (0.0, 0.0, roll), x=shift_px * 0.6 / CAMERA.fx, y=0.3 * shift_px * 0.6 / CAMERA.fy)
    image = images_of(scene_of(square, pose), lit((0.0, 0.0, 0.0)))[-1]
    full = SUN_STRENGTH * 0.6
    corners = CAMERA.project(
        pose.apply(np.array([[-0.1, -0.1, 0], [-0.1, 0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0]]))
    )
    rows = np.arange(95, 145)
    coverage = image[rows].astype(float) / full
    found_left = 159.5 - coverage[:, :160].sum(axis=1)
    found_right = 159.5 + coverage[:, 160:].sum(axis=1)
    for found, (top, bottom) in ((found_left, corners[:2]), (found_right, corners[2:])):
        wanted = top[0] + (rows - top[1]) / (bottom[1] - top[1]) * (bottom[0] - top[0])
        assert abs(np.mean(found - wanted)) < 0.035
        assert np.abs(found - wanted).max() < 0.1


def test_a_cast_shadow_lies_where_the_light_puts_it(tmp_path: Path) -> None:
    # a plate 0.1 m in front of a wall, lit from the left: similar triangles give the shadow's edges
    wall, plate = 1.0, 0.9
    corners = [(-0.6, -0.6, wall), (0.6, -0.6, wall), (0.6, 0.6, wall), (-0.6, 0.6, wall)]
    corners += [(-0.05, -0.2, plate), (0.05, -0.2, plate), (0.05, 0.2, plate), (-0.05, 0.2, plate)]
    scene = scene_of(quad(tmp_path, "plate", corners), at(0.0001))
    light = (-0.8, 0.0, 0.0)
    image = images_of(scene, lit(light))[0]
    right_edge = light[0] + (0.05 - light[0]) * wall / plate
    left_edge = light[0] + (-0.05 - light[0]) * wall / plate
    row = image[120].astype(float)
    dark = np.flatnonzero(row == 0)
    pixels = CAMERA.project(np.array([[right_edge, 0, wall], [0.05, 0, plate], [left_edge, 0, wall]]))[:, 0]
    assert pixels[2] > 159.5 - 400 * 0.05 / plate  # its left edge hides behind the plate, or touches it
    start = max(pixels[1], pixels[2])
    assert dark.min() == pytest.approx(start + 0.5, abs=1.0)
    assert dark.max() == pytest.approx(pixels[0] - 0.5, abs=1.0)


def test_the_disc_of_the_sun_makes_a_penumbra_of_its_own_width(tmp_path: Path) -> None:
    wall, plate = 1.0, 0.8
    corners = [(-0.6, -0.6, wall), (0.6, -0.6, wall), (0.6, 0.6, wall), (-0.6, 0.6, wall)]
    corners += [(-0.3, -0.3, plate), (-0.1, -0.3, plate), (-0.1, 0.3, plate), (-0.3, 0.3, plate)]
    scene = scene_of(quad(tmp_path, "plate", corners), at(0.0001))
    sun = np.array([-0.8, 0.0, -1.0]) / math.hypot(0.8, 1.0)
    widths = []
    for radius in (0.0, math.radians(2.0)):
        row = images_of(scene, lit((0, 0, 0), sun=sun, disc=radius))[-1][120].astype(float)
        share = row[165:230] / row.max()
        widths.append(int(((share > 0.1) & (share < 0.9)).sum()))
    assert widths[0] <= 2
    assert widths[1] > widths[0] + 4


@pytest.mark.parametrize("disc_deg", [0.8, 3.0])
def test_a_penumbra_is_the_share_of_the_disc_that_is_seen(tmp_path: Path, disc_deg: float) -> None:
    # a plate's straight edge hides a disc as a chord does: area of the segment, sampled across the shadow
    wall, plate = 1.0, 0.6
    corners = [(-0.6, -0.6, wall), (0.6, -0.6, wall), (0.6, 0.6, wall), (-0.6, 0.6, wall)]
    corners += [(-0.5, -0.4, plate), (-0.2, -0.4, plate), (-0.2, 0.4, plate), (-0.5, 0.4, plate)]
    scene = scene_of(quad(tmp_path, "plate", corners), at(0.0001))
    sun = np.array([-0.6, 0.0, -1.0]) / math.hypot(0.6, 1.0)
    radius = math.radians(disc_deg) / 2
    row = images_of(scene, lit((0, 0, 0), sun=sun, disc=radius))[-1][120].astype(float)
    x = (np.arange(320) - 159.5) / 400.0  # on the wall, m
    beyond = np.arctan2(x + 0.2, wall - plate) - np.arctan2(0.6, 1.0)  # the edge past the sun's middle, rad
    part = np.clip(beyond / radius, -1, 1)
    share = 1 - (np.arccos(part) - part * np.sqrt(1 - part**2)) / math.pi
    around = x > -0.1  # of the shadow's right edge
    found = row[around] / row[beyond > 2 * radius].mean()
    assert ((share[around] > 0.02) & (share[around] < 0.98)).sum() >= 2
    # a pixel sees the mean of its width, and its places look at a limited number of points of the disc
    assert found == pytest.approx(share[around], abs=0.04)
    assert found.sum() == pytest.approx(share[around].sum(), abs=0.15)


def test_a_face_that_cuts_the_disc_of_the_sun_gets_the_light_of_the_upper_part(square: Model) -> None:
    radius = math.radians(5.0)
    rng = np.random.default_rng(0)
    place = radius * np.sqrt(rng.uniform(size=100000)) * np.sin(rng.uniform(0, 2 * math.pi, 100000))
    for height in (0.5, 0.0, -0.5):  # of the sun's middle above the face, in radii
        angle = height * radius
        sun = np.array([math.cos(angle), 0.0, -math.sin(angle)])
        image = images_of(scene_of(square, at(0.6)), lit((0, 0, 0), sun=sun, disc=radius))[-1]
        wanted = np.maximum(np.sin(angle + place), 0).mean()
        assert middle(image) == pytest.approx(SUN_STRENGTH * 0.6 * wanted, rel=0.12)


def test_microfacets_give_back_what_the_published_model_does() -> None:
    # all light that comes in evenly, reflectance 1: what goes out towards the normal
    cosines = (np.arange(2000) + 0.5) / 2000  # evenly over the hemisphere
    for alpha, wanted, tolerance in (
        (
            1.0,
            1 - math.log(2),
            1e-4,
        ),  # the integral of c / (1 + c): facets hide each other, once scattered is lost
        (0.25, 0.91, 0.02),
        (0.1, 0.98, 0.02),
    ):
        out = 0.0
        for cosine in cosines:
            half = math.sqrt((1 + cosine) / 2)
            out += 2 * microfacets(cosine, 1.0, half, half, alpha, 1.0) * cosine / len(cosines)
        assert out == pytest.approx(wanted, abs=tolerance)


def test_a_polished_face_mirrors_the_sun_in_one_direction_only(square: Model) -> None:
    polished = Material(albedo=0.1, texture="plain", grain=0.0, specular=0.5, roughness=0.2)
    scene = scene_of(square, at(0.6), polished)
    mirrored = middle(images_of(scene, lit((0, 0, 0)))[-1])
    aside = middle(images_of(scene, lit((0, 0, 0), sun=np.array([0.6, 0.0, -0.8])))[-1])
    assert mirrored > 100 * aside


def beamed(light: Light) -> Illumination:
    aim = np.array([light.aim]) / np.linalg.norm(light.aim)
    plain = lit(light.position)
    return Illumination(plain.lights, aim, beam_table(light)[None], plain.sky)


def test_a_beam_falls_as_its_lamp_says(tmp_path: Path) -> None:
    corners = [(-0.6, -0.6, 0.0), (0.6, -0.6, 0.0), (0.6, 0.6, 0.0), (-0.6, 0.6, 0.0)]
    scene = scene_of(quad(tmp_path, "wall", corners), at(0.8))
    everywhere = images_of(scene, lit((0.0, 0.0, 0.0)))[0]
    narrow = images_of(scene, beamed(Light(name="led", position=(0.0, 0.0, 0.0), half_intensity_deg=15.0)))[0]
    table = ((0.0, 1.0), (10.0, 0.6), (14.0, 0.0))
    measured = images_of(scene, beamed(Light(name="torch", position=(0.0, 0.0, 0.0), beam=table)))[0]
    for angle in (0.0, 5.0, 10.0, 13.0, 15.0, 20.0):
        column = round(159.5 + 400.0 * math.tan(math.radians(angle)))
        exact = math.degrees(math.atan(math.hypot(column - 159.5, 0.5) / 400.0))
        share = narrow[120, column] / everywhere[120, column]
        power = math.log(0.5) / math.log(math.cos(math.radians(15.0)))
        assert share == pytest.approx(math.cos(math.radians(exact)) ** power, rel=1e-3)
        wanted = np.interp(exact, *np.array(table).T, right=0.0)
        assert measured[120, column] / everywhere[120, column] == pytest.approx(wanted, abs=2e-3)


def test_a_beam_may_be_aimed_aside(square: Model) -> None:
    aside = Light(name="a", position=(0.0, 0.0, 0.0), aim=(0.3, 0.0, 1.0), half_intensity_deg=10.0)
    image = images_of(scene_of(square, at(0.6)), beamed(aside))[0]
    row = image[120].astype(float)
    assert row[175:225].mean() > 2 * row[95:145].mean() > 0


def test_foil_sparkles_where_a_flat_face_is_even(square: Model) -> None:
    foil = Material(albedo=0.0, texture="plain", grain=0.0, specular=0.9, roughness=0.3, size_m=0.02)
    flat, crinkled = (
        images_of(scene_of(square, at(0.6), msgspec.structs.replace(foil, crinkle=slope)), lit((0, 0, 0)))[-1]
        for slope in (0.0, 0.25)
    )
    lit_flat, lit_foil = flat[flat > 0], crinkled[90:150, 130:190]
    assert lit_foil.std() / lit_foil.mean() > 3 * lit_flat.std() / lit_flat.mean()


def test_folds_are_as_steep_as_the_material_says() -> None:
    surface = np.zeros(texture.COLUMNS)
    surface[texture.SIZE], surface[texture.CRINKLE] = 0.02, 0.2
    slope, slopes = np.zeros(3), []
    for point in np.random.default_rng(0).uniform(0, 1, (4000, 3)):
        texture.crinkled(surface, *point, slope)
        slopes.append(slope.copy())
    assert np.std(slopes, axis=0) == pytest.approx(0.2, rel=0.08)


def test_coverage_and_depth_tell_what_is_where(square: Model) -> None:
    found = traced(scene_of(square, at(0.5)), CAMERA, lit((0, 0, 0)))
    side = 0.2 / 0.5 * 400
    assert found.coverage.sum() == pytest.approx(side**2, rel=2e-3)
    assert found.inverse_depth[119:121, 159:161] == pytest.approx(2.0, rel=1e-5)
    assert found.inverse_depth[0, 0] == 0.0


def test_rows_are_the_same_however_many_are_traced_at_a_time(
    square: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(square, at(0.6, (0.4, -0.3, 0.1)))
    light = lit((-0.35, 0.0, 0.0), disc=0.02)
    whole = traced(scene, CAMERA, light)
    monkeypatch.setattr(tracing, "BAND_PIXELS", 2000)
    pieces = traced(scene, CAMERA, light)
    for one, other in zip(whole.images, pieces.images, strict=True):
        assert np.array_equal(one, other)
    assert np.array_equal(whole.coverage, pieces.coverage)
