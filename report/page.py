"""A run folder becomes one self-contained HTML page and its overlay pictures."""

import shlex
from dataclasses import dataclass
from pathlib import Path

import msgspec
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from report import words
from report.errors import ReportError
from report.figures import approach_figure, session_figures, time_figure, was_kept
from report.overlay import is_small
from report.pictures import (
    Picture,
    Strokes,
    data_uri,
    legibility,
    read_picture,
    strokes_of,
    support_of,
    write_overlay,
)
from report.records import Result, StepRecord, read_result
from report.scene import Scene, read_scene
from report.story import StepView, step_view
from report.uncertainty import uncertainty_of
from report.verdict import HOLD_PASSED, range_of, verdict_of

TEMPLATES = Path(__file__).resolve().parent
CLOSE_UP_PX = 30  # width of an enlarged corner, in pixels of the image
FILES = ("result.json", "history.pl")


@dataclass(frozen=True)
class Hero:
    """The large picture: an image of the set with the final pose over it."""

    picture: Picture
    strokes: Strokes | None
    view: tuple[float, float, float, float] | None
    close_ups: tuple[tuple[float, float], ...]


def write_report(folder: Path) -> Path:
    """Write RUN_FOLDER/report.html and RUN_FOLDER/images/<id>-overlay.png.

    Parameters
    ----------
    folder : a session's run folder (docs/architecture.md): result.json, images/<id>.png, images/stack.toml.

    Returns
    -------
    Path of report.html.

    Raises
    ------
    ReportError : no such folder, no or broken result.json, a folder that cannot be written.
    """
    result = read_result(folder)
    html = render(folder, result)
    path = folder / "report.html"
    try:
        path.write_text(html, encoding="utf-8")
    except OSError as error:
        raise ReportError(f"{path}: cannot be written ({error.strerror})") from error
    return path


def render(folder: Path, result: Result) -> str:
    """The page of a session; writes the overlay pictures on the way.

    Raises
    ------
    ReportError : an image id that is no file name, a picture that cannot be written.
    """
    scene = read_scene(folder)
    lights = tuple(result.lights or scene.lights)
    pictures = [read_picture(folder, step.image, scene) for step in result.steps]
    hero = _hero(result, scene, pictures)
    views: list[StepView] = []
    for number, (step, picture) in enumerate(zip(result.steps, pictures, strict=True), start=1):
        support = support_of(step.lines)
        write_overlay(folder, picture, scene, step.pose, support)
        strokes = strokes_of(scene, step.pose, support)
        views.append(step_view(step, number, picture, strokes, lights, result.steps))
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html.j2").render(
        style=Markup((TEMPLATES / "style.css").read_text(encoding="utf-8")),
        result=result,
        verdict=verdict_of(result),
        words=words,
        hero=hero,
        steps=views,
        sources=_sources(pictures, hero),
        size=_size(scene, pictures),
        notes=scene.notes,
        missing=[picture.problem for picture in pictures if picture.problem],
        lines_known=result.lines is not None or any(step.lines for step in result.steps),
        kept=sum(was_kept(step) for step in result.steps),
        figures=session_figures(result),
        approach=approach_figure(result.holds) if result.holds else None,
        holds=[(hold, uncertainty_of(hold.pose, hold.covariance)) for hold in result.holds or []],
        hold_passed=HOLD_PASSED,
        time=time_figure(result.seconds),
        deviations=uncertainty_of(result.pose, result.covariance),
        range_m=range_of(result.pose) if result.pose else None,
        pose_json=msgspec.json.encode(result.pose).decode() if result.pose else "",
        command=_command(result),
        files=[name for name in FILES if (folder / name).is_file()],
        close_up_px=CLOSE_UP_PX,
        figure_svg=Markup,
    )


def _hero(result: Result, scene: Scene, pictures: list[Picture]) -> Hero | None:
    """The image of the final set in which the target can be made out best."""
    support = support_of(result.lines) or _last_support(result.steps)
    strokes = strokes_of(scene, result.pose, support)
    bounds = strokes.bounds if strokes else None
    last_hold = max((step.hold for step in result.steps if step.hold is not None), default=None)
    candidates = [
        (step, picture)
        for step, picture in zip(result.steps, pictures, strict=True)
        if picture.pixels is not None and (last_hold is None or step.hold == last_hold)
    ]
    chosen = [pair for pair in candidates if pair[1].name in result.kept] or candidates
    if not chosen:
        return None
    picture = max((pair[1] for pair in chosen), key=lambda one: _legibility(one, bounds))
    view = None
    if strokes is not None and scene.camera is not None and is_small(strokes.bounds, scene.camera):
        left, top, right, bottom = strokes.bounds
        pad = 0.12 * max(right - left, bottom - top) + 4
        view = (left - pad, top - pad, right - left + 2 * pad, bottom - top + 2 * pad)
    corners = strokes.corners if strokes else ()
    return Hero(picture, strokes, view, tuple(_close_up(corner, picture) for corner in corners))


def _close_up(corner: tuple[float, float], picture: Picture) -> tuple[float, float]:
    """Left and top of the enlarged part around a corner, moved so that it lies in the image."""
    height, width = picture.pixels.shape if picture.pixels is not None else (0, 0)
    half = CLOSE_UP_PX / 2
    left, top = corner[0] + 0.5 - half, corner[1] + 0.5 - half
    return max(0.0, min(left, width - CLOSE_UP_PX)), max(0.0, min(top, height - CLOSE_UP_PX))


def _legibility(picture: Picture, bounds: tuple[float, float, float, float] | None) -> float:
    return 0.0 if picture.pixels is None else legibility(picture.pixels, bounds)


def _last_support(steps: list[StepRecord]) -> dict[int, float] | None:
    return next((support_of(step.lines) for step in reversed(steps) if step.lines), None)


def _sources(pictures: list[Picture], hero: Hero | None) -> dict[str, str]:
    """Each image once, as a data URI: the page draws it wherever it needs it."""
    sources = {}
    for picture in pictures:
        if picture.pixels is None:
            continue
        large = hero is not None and picture.name == hero.picture.name
        sources[picture.name] = data_uri(picture.pixels, large)
    return sources


def _size(scene: Scene, pictures: list[Picture]) -> tuple[int, int]:
    """Width and height that the page's pictures share."""
    if scene.camera is not None:
        return scene.camera.width, scene.camera.height
    shapes = [picture.pixels.shape for picture in pictures if picture.pixels is not None]
    return (shapes[0][1], shapes[0][0]) if shapes else (4, 3)


def _command(result: Result) -> str:
    if isinstance(result.command, list):
        return shlex.join(result.command)
    return result.command or ""
