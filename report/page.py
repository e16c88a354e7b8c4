"""A run folder becomes one self-contained HTML page and its overlay pictures."""

import shlex
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import msgspec
from markupsafe import Markup

from bridge import __version__
from bridge.command_line import counted
from bridge.errors import BadInput
from bridge.result_file import Result, StepRecord, read_result
from bridge.whole_file import replaced
from report import words
from report.approach import strip_of
from report.figures import approach_figure, session_figures, time_figure, was_kept
from report.following import Journal, ReasonRecord, Told
from report.fragments import environment, short, style
from report.overlay import is_small
from report.pictures import data_uri, legibility, read_picture, write_overlay
from report.scene import Scene, known_lights, read_scene
from report.story import Picture, StepView, step_view
from report.strokes import Strokes, strokes_of, support_of
from report.uncertainty import uncertainty_of
from report.verdict import HOLD_PASSED, range_of, verdict_of

Reasons = dict[str, tuple[ReasonRecord, ReasonRecord]]
CLOSE_UP_PX = 30  # width of an enlarged corner, in pixels of the image
FILES = ("result.json", "history.pl")


@dataclass(frozen=True)
class Hero:
    """The large picture: an image of the set with the final pose over it."""

    picture: Picture
    strokes: Strokes | None
    view: tuple[float, float, float, float] | None
    close_ups: tuple[tuple[float, float], ...]


def write_report(folder: Path, journal: Journal | None = None) -> Path:
    """Write RUN_FOLDER/report.html and RUN_FOLDER/images/<id>-overlay.png.

    Parameters
    ----------
    folder : a session's run folder (docs/architecture.md): result.json, images/<id>.png, images/stack.toml.
    journal : its reader with every reason, where one has been started; it is asked once, and closed.

    Returns
    -------
    Path of report.html.

    Raises
    ------
    BadInput : no such folder, no or broken result.json, a folder that cannot be written.
    """
    result = read_result(folder)
    with closing(journal or Journal(folder, every_reason=True)) as reader, ThreadPoolExecutor(1) as pool:
        html = render(folder, result, pool.submit(reader.ask))  # it reads while pictures are read and drawn
    path = folder / "report.html"
    try:
        with replaced(path) as new:
            new.write_text(html, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror})") from error
    return path


def render(folder: Path, result: Result, asked: Future[Told]) -> str:
    """The page of a session, with what its journal was asked for; writes the overlay pictures on the way.

    Raises
    ------
    BadInput : an image id that is no file name, a picture that cannot be written.
    """
    scene = read_scene(folder)
    lights = known_lights(result, scene)
    pictures = [read_picture(folder, step.image, scene) for step in result.steps]
    verdict = verdict_of(result)
    result, last_hold = _last_fixed(result)
    hero = _hero(result, last_hold, scene, pictures)
    views: list[StepView] = []
    for number, (step, picture) in enumerate(zip(result.steps, pictures, strict=True), start=1):
        support = support_of(step.lines)
        write_overlay(folder, picture, scene, step.pose, support)
        strokes = strokes_of(scene, step.pose, support)
        views.append(step_view(step, number, picture, strokes, lights, result.steps))
    figures = session_figures(result)
    told = asked.result()
    return (
        environment()
        .get_template("page.html.j2")
        .render(
            style=style(),
            version=__version__,
            result=result,
            verdict=verdict,
            words=words,
            counted=counted,
            hero=hero,
            steps=views,
            sources=_sources(pictures, hero),
            size=_size(scene, pictures),
            notes=[*scene.notes, *_other_settings(result.steps), *_untold(told)],
            reasons=_reasons(told),
            actions=told.actions,
            short=short,
            missing=[picture.problem for picture in pictures if picture.problem],
            lines_known=result.lines is not None or any(step.lines for step in result.steps),
            kept=sum(was_kept(step) for step in result.steps),
            figures=figures,
            approach=approach_figure(result.holds) if result.holds else None,
            holds=[(hold, uncertainty_of(hold.pose, hold.covariance)) for hold in result.holds or []],
            strip=strip_of(
                result,
                {picture.name for picture in pictures if picture.pixels is not None},
                lambda pose: strokes_of(scene, pose, None),
            ),
            hold_passed=HOLD_PASSED,
            time=time_figure(result.seconds),
            deviations=uncertainty_of(result.pose, result.covariance),
            range_m=range_of(result.pose) if result.pose else None,
            pose_json=msgspec.json.encode(result.pose).decode() if result.pose else "",
            command=result.command,
            again=_again(folder, result),
            files=[name for name in FILES if (folder / name).is_file()],
            close_up_px=CLOSE_UP_PX,
            svg=Markup,
        )
    )


def _untold(told: Told) -> list[str]:
    """A note where the journal is there and cannot be followed."""
    return [f"Reasons and journal cannot be shown. {told.problem}"] if told.problem else []


def _reasons(told: Told) -> Reasons:
    """Why each image was taken under its settings, and what it showed, by its name."""
    reasons: Reasons = {}
    chosen = None
    for action in told.actions:
        if action.reason is not None and action.reason.kind == "chosen":
            chosen = action.reason
        elif action.reason is not None and action.reason.kind == "seen" and chosen is not None:
            reasons[action.text.removeprefix("capture(").partition(",")[0]] = (chosen, action.reason)
    return reasons


def _other_settings(steps: list[StepRecord]) -> list[str]:
    """A note where images were taken under other settings than were asked for."""
    others = [f"{step.image} ({step.settings_words})" for step in steps if step.asked is not None]
    if not others:
        return []
    return [f"Taken under other settings than were asked for: {'; '.join(others)}."]


def _last_fixed(result: Result) -> tuple[Result, int | None]:
    """What the head of the page shows, and the hold point that it belongs to, from 1.

    Where an approach ended between hold points that is what was fixed at the last one.
    """
    holds = list(enumerate(result.holds or [], start=1))
    for number, hold in reversed(holds if result.pose is None else []):
        if hold.pose is not None and hold.status in HOLD_PASSED:
            fixed = {name: getattr(hold, name) for name in ("pose", "covariance", "rms_px", "error", "lines")}
            shown = msgspec.structs.replace(
                result, merit_px=hold.merit, uncertainty=hold.uncertainty, **fixed
            )
            return shown, number
    return result, max((step.hold for step in result.steps if step.hold is not None), default=None)


def _hero(result: Result, last_hold: int | None, scene: Scene, pictures: list[Picture]) -> Hero | None:
    """The image of the final set in which the target can be made out best."""
    support = support_of(result.lines) or _last_support(result.steps)
    strokes = strokes_of(scene, result.pose, support)
    bounds = strokes.bounds if strokes else None
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
        if picture.edges is not None:
            sources[f"{picture.name}-edges"] = data_uri(picture.edges, True)
    return sources


def _size(scene: Scene, pictures: list[Picture]) -> tuple[int, int]:
    """Width and height that the page's pictures share."""
    if scene.camera is not None:
        return scene.camera.width, scene.camera.height
    shapes = [picture.pixels.shape for picture in pictures if picture.pixels is not None]
    return (shapes[0][1], shapes[0][0]) if shapes else (4, 3)


def _again(folder: Path, result: Result) -> str:
    """The command that does the session again: its own may name a folder that is in use now."""
    if not result.command or not (folder / "session.pl").is_file():
        return ""
    return f"{result.command.partition(' -')[0]} --again {shlex.quote(str(folder.resolve()))}"
