"""The parts of the live page, each as HTML of its own, so that only what has changed is sent."""

from __future__ import annotations

import os
import re
import shlex
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemBytecodeCache, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from bridge.result_file import StepRecord
from report import words
from report.approach import strip_of
from report.ellipsoid import ellipsoid_svg
from report.figures import session_figures, time_figure, was_kept
from report.following import ReasonRecord, State
from report.scene import LightRecord, known_lights, read_scene
from report.story import Picture, step_view
from report.strokes import strokes_of, support_of
from report.uncertainty import uncertainty_of
from report.verdict import verdict_of

HERE = Path(__file__).resolve().parent
COMPILED = HERE / "__pycache__"  # where Python keeps this module, too
PARTS = ("status", "now", "approach", "choice", "set", "course", "pose", "program", "events", "time")
MOST_EVENTS = 40  # the newest of them
WORD = re.compile(r"[a-z]\w*")
LONG_NUMBER = re.compile(r"\b\d+\.\d{5,}\b")


@cache
def environment() -> Environment:
    """Templates of the pages: escaped, and strict about what they name; compiled once, as modules are."""
    kept = os.access(COMPILED, os.W_OK | os.X_OK)
    return Environment(
        loader=FileSystemLoader(HERE),
        bytecode_cache=FileSystemBytecodeCache(str(COMPILED)) if kept else None,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def style(*more: str) -> Markup:
    """The style sheet of a page: colours, what all pages have, and more files of this folder."""
    files = (HERE / name for name in ("colours.css", "style.css", *more))
    return Markup("".join(file.read_text(encoding="utf-8") for file in files))


def live_page(token: str) -> str:
    """The page into which the parts are put."""
    return (
        environment()
        .get_template("live.html.j2")
        .render(
            style=style("live.css"),
            script=Markup((HERE / "live.js").read_text(encoding="utf-8")),
            token=token,
        )
    )


def fragments(folder: Path, state: State, token: str) -> dict[str, str]:
    """HTML of every part of the page.

    Parameters
    ----------
    folder : the run folder, for images, camera and model.
    state : of the session.
    token : that images are asked for with.
    """
    result, told = state.result, state.told
    scene = read_scene(folder)
    lights = known_lights(result, scene)
    images = sorted(
        (file.stem for file in (folder / "images").glob("*.png") if "-" not in file.stem), key=_number
    )
    newest = images[-1] if images else ""
    last = result.steps[-1] if result.steps else None
    support = support_of(result.lines) or (support_of(last.lines) if last else None)
    values: dict[str, Any] = {
        "state": state,
        "folder": shlex.quote(str(folder)),
        "verdict": verdict_of(result) if state.ended else None,
        "unknown": bool(told.problem) and not state.ended,
        "result": result,
        "words": words,
        "token": token,
        "size": (scene.camera.width, scene.camera.height) if scene.camera else (4, 3),
        "newest": newest,
        "edges": next((name for name in reversed(images) if _drawn(folder, name)), ""),
        "strokes": strokes_of(scene, result.pose, support, at_once=True),
        "strip": strip_of(
            result, images, lambda pose: strokes_of(scene, pose, None, at_once=True), not state.ended
        ),
        "notes": scene.notes if images else (),
        "steps": [_view(step, number, result.steps, lights) for number, step in enumerate(result.steps, 1)],
        "kept": sum(was_kept(step) for step in result.steps),
        "choice": _last(state, "chosen"),
        "seen": _last(state, "seen"),
        "figures": session_figures(result),
        "time": time_figure(result.seconds) if result.seconds else None,
        "deviations": uncertainty_of(result.pose, result.covariance),
        "ellipsoid": Markup(ellipsoid_svg(result.pose, result.covariance)),
        "source": program_source(told.controller_file, told.left),
        "events": told.actions[-MOST_EVENTS:][::-1],
        "short": short,
        "svg": Markup,
    }
    module = environment().get_template("live_parts.html.j2").make_module(values)
    return {name: str(getattr(module, f"part_{name}")()).strip() for name in PARTS}


def program_source(file: str | None, left: str) -> Markup:
    """The controller's text; the first of its words that is left to do is marked."""
    if file is None:
        return Markup("")
    try:
        text = Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return Markup("")
    code = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("%"))
    body = code.partition(",")[2] if code.lstrip().startswith("proc(") else code
    known = set(WORD.findall(body))
    here = next((word for word in WORD.findall(left) if word in known), None)
    marked = escape(code.strip())
    if here is None:
        return marked
    return Markup(re.sub(rf"(?<!^proc\()\b{here}\b", f"<mark>{here}</mark>", str(marked), flags=re.MULTILINE))


def short(text: str) -> str:
    """An action without the many digits of its numbers: four tell shutters apart."""
    return LONG_NUMBER.sub(lambda found: f"{float(found[0]):.4g}", text)


def _view(step: StepRecord, number: int, steps: list[StepRecord], lights: tuple[LightRecord, ...]) -> Any:
    return step_view(step, number, Picture(step.image or "", None), None, lights, steps)


def _last(state: State, kind: str) -> ReasonRecord | None:
    reasons = (action.reason for action in reversed(state.told.actions))
    return next((reason for reason in reasons if reason is not None and reason.kind == kind), None)


def _drawn(folder: Path, name: str) -> bool:
    return (folder / "images" / f"{name}-edges.png").is_file()


def _number(name: str) -> tuple[int, str]:
    digits = re.sub(r"\D", "", name)
    return int(digits or 0), name
