"""The simulated device: traces each geometry once, then mixes and exposes (the sensor: `stack.sensor`)."""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from bridge.errors import BadInput
from bridge.image_messages import MoveDone, PoseErrorMessage
from bridge.messages import Describe, PoseMessage, Settings
from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import find_target, load_model
from geometry.pose import Pose
from image_server.replay import pose_error
from image_server.serve.device import Change, Device, Frame, checked_settings, sure_frame
from image_server.simulator import placement
from image_server.simulator.description import described, pose_message
from image_server.simulator.drift import Drift
from image_server.simulator.lens import focused, zoomed
from image_server.simulator.material import load_appearance
from image_server.simulator.scenario import load_scenario, of_size
from image_server.simulator.scenario_tables import Scenario
from image_server.simulator.scene import Scene, background_parts, joined, target_part
from image_server.simulator.view import Radiances, TracedView, rendered, sky_of
from numerics.arrays import Field, Floats
from stack.exposure import level_fraction
from stack.sensor import check_blur, exposed, mixed

POSE, SEED_POSE, SUN, BACKGROUND, MOVES, DRIFT, STARS = range(1, 8)
"""Streams of random numbers, so that one draw more in one place changes nothing elsewhere."""
FEWEST_KEPT = 4  # geometries that were traced: focal lengths, or those of the session before
KEPT_BYTES = 1 << 26  # of more than these; a session of six captures, each of another geometry, has 45 MB


class Simulator(Device):
    """A ray-traced target with lights and a sun.

    Parameters
    ----------
    target : a name of `targets/`, or a model file.
    scenario : a scenario, or the name or file of one.
    seed : draws poses, sun, background and noise.
    unit : of the model file.
    captures_taken, moves : by an earlier process of the same session; it goes on from there.

    Attributes
    ----------
    model, model_file : the target's geometry, and where it was read from.
    sensor : and the blur in front of it.
    true_pose : for tests and benchmarks; no reply of a server tells it.
    seed_pose : where the target is said to be; None after a move.

    Raises
    ------
    BadInput : a target or scenario that cannot be used.
    """

    name = "simulator"

    def __init__(
        self,
        target: str | Path = "cube",
        scenario: Scenario | str = "nominal",
        seed: int = 0,
        unit: str = "m",
        captures_taken: int = 0,
        moves: Sequence[MoveDone] = (),
    ) -> None:
        told = load_scenario(scenario) if isinstance(scenario, str) else scenario
        try:
            self.model_file = find_target(str(target)).resolve()
            self.model = load_model(self.model_file, unit)
        except GeometryError as error:
            raise BadInput(f"{error}.") from None
        if not self.model.faces:
            raise BadInput(
                f"model {self.model_file} has lines alone, and no faces that light could fall on.",
                "Give a model with faces, or images: a --stack or a --camera.",
            )
        self._scenario = of_size(told, self.model.diameter)
        self._nearest_m = placement.LEAST_RANGE_DIAMETERS * self.model.diameter
        self._unit = unit
        self._appearance = load_appearance(self.model_file, len(self.model.faces))
        self.sensor = self._scenario.camera
        check_blur(self.sensor, "The scenario")
        try:
            self._camera = Camera.from_dict(msgspec.to_builtins(self.sensor))
        except GeometryError as error:
            raise BadInput(f"The scenario's {error}.") from None
        placement.check_draw(self._scenario.pose, self.model, self._camera)
        self._notify: Callable[[Change], None] = lambda change: None
        self._traced: OrderedDict[Hashable, TracedView] = OrderedDict()  # of seeds before, too
        self.restart(seed, captures_taken, moves)

    def restart(self, seed: int, captures_taken: int, moves: Sequence[MoveDone] = ()) -> list[Change]:
        """Draw true pose, seed pose and sun from another seed, then let pass what has happened since."""
        self._begin(seed)
        changes: list[Change] = []
        for move in moves:
            self._let_pass(move.captures_taken)
            changes = self.move(move.range_m)
        return self._let_pass(captures_taken) if captures_taken > self._captures else changes

    def come_to(self, number: int) -> None:
        """The scene as before the capture of this number."""
        if number != self._captures + 1:
            self.restart(self._seed, number - 1, [m for m in self._moves if m.captures_taken < number])

    def _let_pass(self, captures_taken: int) -> list[Change]:
        """The scene as after so many captures; what changed before the last of them."""
        changes: list[Change] = []
        while self._captures < captures_taken:
            changes = self._advance()
            self._captures += 1
        return changes

    def _begin(self, seed: int) -> None:
        self._seed = seed
        front = np.array(self._appearance.front)
        self.true_pose = placement.drawn_pose(
            self._scenario.pose, self.model, front, self._camera, self._random(POSE)
        )
        self.seed_pose: Pose | None = placement.seed_pose_of(
            self.true_pose,
            self.model,
            self._camera,
            self._scenario.pose.search_fraction,
            self._random(SEED_POSE),
        )
        self._sun = self._drawn_sun()
        axis = placement.sun_axis(self._sun, self._random(DRIFT))
        self._drift = Drift(self._scenario.time, self.true_pose, self._sun, axis)
        self._ambient_scale = self._scenario.ambient_scale
        table = self.sensor
        self._focal_mm = table.focal_lengths_mm[0] if table.focal_lengths_mm else None
        self._focus_m = table.focuses_m[0] if table.focuses_m else None
        self._captures = 0
        self._moves: list[MoveDone] = []
        self._left: list[Pose] = []  # true poses that moves ended

    @property
    def camera(self) -> Camera:
        """The camera at the focal length in use."""
        return zoomed(self._camera, self.sensor.focal_lengths_mm, self._focal_mm)

    def describe(self) -> Describe:
        """Settings, camera at the focal length in use, target and seed pose."""
        return described(
            self.name,
            self._scenario,
            self.camera,
            self.model_file,
            self._unit,
            self.seed_pose,
            self._nearest_m,
        )

    def listen(self, notify: Callable[[Change], None]) -> None:
        """Tell of what the scenario's clock changes; it happens before the capture that first sees it."""
        self._notify = notify

    def capture(self, settings: Settings) -> Frame:
        """Mix the traced images of this geometry and expose; the first capture of a geometry traces it."""
        applied = checked_settings(self.describe(), settings)
        if applied.focal_length_mm is not None:
            self._focal_mm = applied.focal_length_mm
        if applied.focus_m is not None:
            self._focus_m = applied.focus_m
        for change in self._advance():
            self._notify(change)
        image = self._through_lens(self.radiance(applied.lights), applied.aperture)
        image = self._drift.smeared(
            image, self.camera, self.true_pose, self._view().target_depth, applied.shutter_s
        )
        self._captures += 1
        pixels = exposed(
            image, self.sensor, applied.shutter_s, applied.aperture, (self._seed, self._captures)
        )
        return sure_frame(pixels, settings, applied, self._captures, self.name)

    def radiance(self, levels: tuple[int, ...]) -> Field:
        """Linear radiance (H, W) float32 without blur and noise; 1 clips at 1/60 s, f/4 and gain 1."""
        lights = zip(self._scenario.lights, levels, strict=True)
        return self.radiance_of([level_fraction(level, light.levels) for light, level in lights])

    def radiance_of(self, shares: Sequence[float]) -> Field:
        """The same with each light at a share of its full power."""
        powers = [
            light.power * self._scenario.light_power * share
            for light, share in zip(self._scenario.lights, shares, strict=True)
        ]
        return mixed(self.basis(), [*powers, self._ambient_scale])

    def basis(self) -> Radiances:
        """Radiance images of this geometry: each light alone (full, power 1), then sun, Earth and stars."""
        return self._view().images

    def _view(self) -> TracedView:
        pose = self.true_pose
        key = (
            self._seed, self._focal_mm, pose.rotation_vector.tobytes(), pose.translation.tobytes(),
            self._sun.tobytes(),
        )  # fmt: skip
        view = self._traced.get(key)
        if view is None:
            view = rendered(self._scenario, self._scene(), self.camera, self._sun, self._random(STARS))
            self._traced[key] = view
            while len(self._traced) > FEWEST_KEPT and len(self._traced) * view.size_bytes > KEPT_BYTES:
                self._traced.popitem(last=False)
        self._traced.move_to_end(key)
        return view

    def _through_lens(self, radiance: Field, aperture: float) -> Field:
        """Out of focus where the lens is not focused on it."""
        if self._focus_m is None:
            return radiance
        table, camera = self.sensor, self.camera
        focal_m = table.fx * table.pixel_um * 1e-6
        if self._focal_mm is not None:
            focal_m = self._focal_mm * 1e-3
        return focused(radiance, self._view().inverse_depth, camera.fx, focal_m / aperture, self._focus_m)

    def _advance(self) -> list[Change]:
        """The time from one capture to the next passes."""
        if self._captures == 0 or self._drift.stands_still:
            return []
        self.true_pose, self._sun, changes = self._drift.advanced(self.true_pose, self._sun)
        return changes

    def health(self) -> dict[str, Any]:
        """A simulator does not fall ill."""
        return {"status": "ok", "captures": self._captures, "moves": len(self._moves)}

    def move(self, range_m: float) -> list[Change]:
        """Bring the target to a range along its line of sight; errors and the new sun come from the seed.

        Raises
        ------
        BadInput : so near that the target would touch the camera.
        """
        if range_m < self._nearest_m:
            raise BadInput(
                f"The target cannot come to {range_m:g} m: it is {self.model.diameter:.2g} m large.",
                f"Allowed: {self._nearest_m:.2g} m or more.",
            )
        rng = self._random(MOVES, len(self._moves))
        move = self._scenario.move
        self._left.append(self.true_pose)
        self.true_pose = placement.moved_pose(self.true_pose, range_m, move, rng)
        self.seed_pose = None
        self._moves.append(MoveDone(range_m=range_m, captures_taken=self._captures))
        changes = [Change("target_moved", {"range_m": range_m})]
        if move.sun_turn_deg > 0 or move.sun_factor != (1.0, 1.0):
            self._sun = placement.turned_sun(self._sun, move.sun_turn_deg, rng)
            self._ambient_scale *= rng.uniform(*move.sun_factor)
            changes.append(Change("sun_changed"))
        self._drift.tell(self.true_pose, self._sun)
        return changes

    def score(self, pose: PoseMessage, moves: int | None = None) -> PoseErrorMessage:
        """Error against the true pose, or the one that the target left with the move after so many.

        Raises
        ------
        BadInput : there were fewer moves.
        """
        true_poses = [*self._left, self.true_pose]
        if moves is not None and moves >= len(true_poses):
            raise BadInput(f"The target was moved {len(self._left)} times, not {moves}.")
        return pose_error(pose, pose_message(true_poses[-1 if moves is None else moves]), self.model)

    def _drawn_sun(self) -> Floats:
        """The sun where the scenario puts it; drawn again while the Earth hides it."""
        scenario, rng = self._scenario, self._random(SUN)
        for _ in range(placement.TRIES):
            sun = placement.drawn_sun(scenario.sun, self.model, self.true_pose, rng)
            if not sky_of(scenario, sun).hides_sun(sun):
                return sun
        raise BadInput(
            "The scenario's sun stands behind its Earth.",
            "Change [sun] or [earth] direction; night is ambient_scale = 0.",
        )

    def _scene(self) -> Scene:
        scenario = self._scenario
        parts = [target_part(self.model, self._appearance, scenario.target, self.true_pose)]
        parts += background_parts(
            scenario.background, self.camera, self.true_pose, self.model.diameter, self._random(BACKGROUND)
        )
        return joined(parts)

    def _random(self, *stream: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, *stream])
