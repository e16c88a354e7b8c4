"""The tables of a scenario: sun, lights, camera, background and where the target is drawn."""

from typing import Annotated, Literal

from msgspec import Meta

from bridge.messages import Coordinate, Vector3
from image_server.simulator.material import MaterialChanges
from stack.format import CameraTable, Strength
from stack.tables import Table

# Chosen by hand, beyond anything of use, so that what is made of them is finite and messages hold it; those
# of lengths in metres also where `of_size` has multiplied them, at most by 37.5.
NotNegative = Annotated[float, Meta(ge=0, le=1e9)]
Positive = Annotated[float, Meta(ge=1e-9, le=1e9)]
FARTHEST_M = 1e5  # lateral shifts are beyond
Range = Annotated[float, Meta(gt=0, le=FARTHEST_M)]
Place = Annotated[float, Meta(ge=-2e4, le=2e4)]  # m
Focus = Annotated[float, Meta(ge=1e-3, le=2e4)]  # m
FocalLength = Annotated[float, Meta(ge=1e-3, le=1e6)]  # mm
FocalPixels = Annotated[float, Meta(ge=1, le=1e6)]
Fraction = Annotated[float, Meta(ge=0, le=1)]
HalfTurn = Annotated[float, Meta(ge=0, le=180)]


class Light(Table, frozen=True):
    """One of `[[lights]]`: a point that shines with the square of the distance.

    Attributes
    ----------
    position
        Camera frame, metres.
    aim
        Where the middle of its beam points, camera frame.
    half_intensity_deg
        A lamp whose intensity falls as a power of the cosine from `aim` and is half at this angle, as
        manufacturers of LEDs state it. None: the same to all sides.
    beam
        Measured instead: pairs of angle from `aim` (degrees, growing) and relative intensity, joined by
        straight lines, 0 beyond the last.
    """

    name: str
    position: tuple[Place, Place, Place]
    levels: Annotated[int, Meta(ge=1, le=65536)] = 8
    power: Strength = 1.0
    aim: Vector3 = (0.0, 0.0, 1.0)
    half_intensity_deg: Annotated[float, Meta(ge=1, lt=90)] | None = None
    beam: Annotated[tuple[tuple[HalfTurn, NotNegative], ...], Meta(min_length=2)] | None = None


DEFAULT_LIGHTS = (
    Light(name="left", position=(-0.35, 0.0, 0.0)),
    Light(name="right", position=(0.35, 0.0, 0.0)),
    Light(name="top", position=(0.0, -0.35, 0.0)),
)


class ScenarioCamera(CameraTable, frozen=True):
    """`[camera]`: the keys of a stack's, all with defaults, and the lens.

    Attributes
    ----------
    focal_lengths_mm
        What a zoom lens offers; fx and fy hold for the first and grow in proportion. None: a fixed lens.
    pixel_um
        Distance of neighbouring pixels on the sensor; with fx it tells the width of the aperture.
    focuses_m
        Distances at which the lens can be focused; it starts at the first. None: sharp at every distance.
    vignetting
        The image darkens as the cosine of the field angle to this power: 4 for a plain lens, 0 not at all.
    glare
        Share of the light that lens and housing scatter over the frame.
    """

    width: Annotated[int, Meta(ge=8, le=8192)] = 640
    height: Annotated[int, Meta(ge=8, le=8192)] = 480
    fx: FocalPixels = 800.0
    fy: FocalPixels = 800.0
    cx: Coordinate = 319.5
    cy: Coordinate = 239.5
    gain: Positive = 2.0
    gamma: Positive = 1.0
    read_noise_e: NotNegative = 6.0
    full_well_e: Positive = 10000.0
    focal_lengths_mm: Annotated[tuple[FocalLength, ...], Meta(min_length=1)] | None = None
    pixel_um: Positive = 10.0
    focuses_m: Annotated[tuple[Focus, ...], Meta(min_length=1)] | None = None
    vignetting: Annotated[float, Meta(ge=0, le=8)] = 0.0
    glare: Annotated[float, Meta(ge=0, le=0.5)] = 0.0


class Sun(Table, frozen=True):
    """`[sun]`: where it stands, seen from the target.

    Attributes
    ----------
    angle_deg
        Range of the angle between the directions to the sun and to the camera: 0 is behind the camera, 90
        grazing, 180 behind the target.
    azimuth_deg
        Range of the angle around the line of sight: 0 right, 90 below, 180 left, -90 above the target.
    direction
        Towards the sun in the camera frame, instead of a draw.
    glint
        Put the sun where the largest visible face mirrors it into the camera.
    angular_diameter_deg
        As seen from the target; makes penumbras. The sun's own is 0.53; 0 is a point.
    earthshine
        Light from all sides, as a fraction of the sun's on a face turned to it; unless `[earth]` says where
        the Earth is.
    """

    angle_deg: tuple[HalfTurn, HalfTurn] = (25.0, 60.0)
    azimuth_deg: tuple[Coordinate, Coordinate] = (-180.0, 180.0)
    direction: Vector3 | None = None
    glint: bool = False
    angular_diameter_deg: Annotated[float, Meta(ge=0, le=20)] = 0.53
    earthshine: Fraction = 0.02


class ScenarioEarth(Table, frozen=True):
    """`[earth]`: the Earth, seen as a disc with clouds and air, and the light it sends back.

    Attributes
    ----------
    direction
        To its middle, camera frame.
    altitude_km
        Of the target; 400 km makes a disc of 70 degrees to each side.
    albedo
        Share of the sun's light that it sends back.
    """

    direction: Vector3
    altitude_km: Annotated[float, Meta(ge=100, le=400000)] = 400.0
    albedo: Fraction = 0.3


class Background(Table, frozen=True):
    """`[background]`: open space, a wall behind the target, or that wall with boxes around the target.

    `arm` is the width of a bar before the target, right across it or ending there, over the target's
    diameter; 0 for none. `star_brightness` draws stars as bright as they are (1: none shows in an exposure
    that suits a sunlit target), or so many times brighter.
    """

    kind: Literal["space", "wall", "clutter"] = "space"
    distance_m: NotNegative = 0.25
    boxes: Annotated[int, Meta(ge=0, le=20)] = 4
    arm: Fraction = 0.0
    tilt_deg: Annotated[float, Meta(ge=0, le=60)] = 12.0
    material: MaterialChanges = MaterialChanges()
    star_brightness: NotNegative = 0.0


class PoseDraw(Table, frozen=True):
    """`[pose]`: where the seed draws the true pose, and how far off the seed pose may be.

    Attributes
    ----------
    range_m
        Distance of what a search turns about, the target's origin or its middle. None: RANGE_M, in proportion
        for a target of unusual size.
    orientation
        `views`: the target's front turned from the camera by `tilt_deg` (uniform over the sphere), rolled
        by up to `roll_deg`; `uniform`: any orientation that shows `least_faces` faces well.
    centre_px
        How far from the image centre the target's origin may be, (x, y).
    inside_fraction
        Share of the model's lines that must fall into the frame (if any drawn pose allows it).
    search_fraction
        Share of the search range (docs/architecture.md) that the seed pose's error is drawn from.
    """

    range_m: tuple[Range, Range] | None = None
    orientation: Literal["views", "uniform"] = "views"
    tilt_deg: tuple[HalfTurn, HalfTurn] = (20.0, 50.0)
    roll_deg: HalfTurn = 30.0
    least_faces: Annotated[int, Meta(ge=1, le=10)] = 2
    centre_px: tuple[NotNegative, NotNegative] = (80.0, 60.0)
    inside_fraction: Fraction = 1.0
    search_fraction: Fraction = 1.0


class Move(Table, frozen=True):
    """`[move]`: what goes wrong when the target is brought closer, and what the sun does meanwhile.

    Fractions are standard deviations over the range; the sun turns by `sun_turn_deg` about a drawn axis and
    its strength is multiplied by a draw from `sun_factor`.
    """

    range_fraction: Annotated[float, Meta(ge=0, le=0.2)] = 0.01
    lateral_fraction: Annotated[float, Meta(ge=0, le=0.2)] = 0.01
    attitude_deg: Annotated[float, Meta(ge=0, le=30)] = 2.0
    sun_turn_deg: HalfTurn = 0.0
    sun_factor: tuple[NotNegative, NotNegative] = (1.0, 1.0)


class Time(Table, frozen=True):
    """`[time]`: what changes by itself. Each capture advances the clock, so that a seed still says it all.

    Attributes
    ----------
    seconds_per_capture
        From one capture to the next.
    sun_deg_per_s
        The sun turns about an axis, drawn across it.
    velocity_m_per_s, spin_deg_per_s
        Of the target in the camera frame; it turns about its origin. Velocity blurs the image, too.
    sun_event_deg
        `sun_changed` is published when the sun has turned this far since it was last.
    target_event_fraction, target_event_deg
        `target_moved` is published when the target has gone this far, as a fraction of its range, or turned
        this far.
    """

    seconds_per_capture: NotNegative = 0.0
    sun_deg_per_s: Coordinate = 0.0
    velocity_m_per_s: Vector3 = (0.0, 0.0, 0.0)
    spin_deg_per_s: Vector3 = (0.0, 0.0, 0.0)
    sun_event_deg: Positive = 10.0
    target_event_fraction: Positive = 0.005
    target_event_deg: Positive = 0.5


class Scenario(Table, frozen=True):
    """A scenario file.

    Attributes
    ----------
    ambient_scale
        Strength of sun and earth-shine: 0 is eclipse, 1 compares with the lights, 100 outshines them.
    light_power
        Multiplies the power of every light.
    in_proportion
        For a target of unusual size range, lamps, wall and focus are as much nearer or farther: `of_size`. A
        file that states where one of them is, and not this key, means what it states.
    target
        Changes to the material of every face of the target.
    """

    description: str = ""
    ambient_scale: Strength = 1.0
    light_power: Strength = 1.0
    in_proportion: bool = True
    camera: ScenarioCamera = ScenarioCamera()
    lights: Annotated[tuple[Light, ...], Meta(min_length=1)] = DEFAULT_LIGHTS
    sun: Sun = Sun()
    earth: ScenarioEarth | None = None
    background: Background = Background()
    pose: PoseDraw = PoseDraw()
    move: Move = Move()
    time: Time = Time()
    target: MaterialChanges = MaterialChanges()
