"""What if one image had been taken under other settings: the session again, both ways side by side."""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from bridge.command_line import counted
from bridge.errors import BadInput
from bridge.result_file import Result, StepRecord, read_result
from bridge.stopping import Stopped, Stopping
from bridge.whole_file import replaced
from report import words

MAIN = Path(__file__).resolve().parent.parent / "main.pl"
OF_INSTEAD = re.compile(r"'i\d+: ")  # of the image, which nobody who asks what if has written
ENDED = (0, 3)  # exit statuses of a session that came to its end
LONGER = 20.0  # the other way may take so many times as long as the session (chosen by hand), and at least:
LEAST_S = 120.0
SAME_PX = 1e-6  # errors of the same images, px: sums may differ in their last bits


@dataclass(frozen=True)
class WhatIf:
    """A session and its other way.

    Attributes
    ----------
    at : number of the image that was taken under other settings, from 1.
    folders, results : of the session as it was, and of the other.
    """

    at: int
    folders: tuple[Path, Path]
    results: tuple[Result, Result]

    def rows(self) -> list[tuple[str, StepRecord | None, StepRecord | None]]:
        """Each image from the decision on, as it was and as it would have been."""
        was, other = (result.steps[self.at - 1 :] for result in self.results)
        return [
            (
                f"i{self.at + number}",
                was[number] if number < len(was) else None,
                other[number] if number < len(other) else None,
            )
            for number in range(max(len(was), len(other)))
        ]

    def asked(self, side: int, step: StepRecord | None) -> str:
        """What was asked for, where an image was taken otherwise: a nearest frame, a dead light."""
        if step is None or step.asked is None:
            return ""
        lights = self.results[side].lights or ()
        return f"asked for {words.settings(step.asked, lights)}; taken under"

    def ends(self) -> list[tuple[str, str, str]]:
        """What each way came to, by name."""
        was, other = (_end(result) for result in self.results)
        return [(name, was[name], other[name]) for name in was]


def what_if(folder: Path, at: int, settings: str, out: Path | None) -> WhatIf:
    """Do a session again up to an image, take that under other settings, and let the strategy go on.

    Parameters
    ----------
    folder : run folder of a session on the simulator or on recorded stacks, which do the same again.
    at : number of the image, from 1.
    settings : as a session shows them, such as `left 7 right 0 top 0, 1/60 s, f/4`; lights not named are off.
    out : run folder of the other way; by default beside the first.

    Raises
    ------
    BadInput : a folder, image or settings that cannot be used, or a session that does not go the same way.
    """
    was = read_result(folder)
    if not 1 <= at <= len(was.steps):
        raise BadInput(
            f"{folder}: --at {at}: there is no such image; it took {counted(len(was.steps), 'image')}"
        )
    command = (was.command or "").split()
    for word in ("--camera", "--image-server", "--vision-server"):
        if word in command:
            raise BadInput(
                f"{folder}: the session used {word}, which cannot do the same again;"
                " what if is for sessions on the simulator and on stacks"
            )
    again = ["--again", str(folder)] + ["--keep-servers"] * ("--keep-servers" in command)
    out = out or folder.with_name(f"{folder.resolve().name}-whatif-{at}")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise BadInput(f"{out}: is there already; remove it, or name another folder with --out")
    there = out.exists()
    try:
        _run([*again, "--instead", f"i{at}: {settings}", "--out", str(out)], was.seconds.get("total"))
    except (BadInput, Stopped):
        if not there:
            shutil.rmtree(out, ignore_errors=True)
        raise
    done = WhatIf(at, (folder, out), (was, read_result(out)))
    _check_same_way(done)
    return done


def _run(options: list[str], seconds: float | None) -> None:
    deadline_s = max(LEAST_S, LONGER * (seconds or 0.0))
    try:
        with Stopping() as stopping, stopping.waiting():
            done = subprocess.run(
                ["swipl", str(MAIN), *options, "--quiet"],
                env=os.environ | {"LIGHTS_AND_CAMERA_PYTHON": sys.executable},
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                text=True, timeout=deadline_s, check=False,
            )  # fmt: skip
    except FileNotFoundError as error:
        raise BadInput("there is no `swipl` on the PATH; install SWI-Prolog 9.0.4 or newer") from error
    except subprocess.TimeoutExpired as error:
        raise BadInput(f"the other way has not ended within {deadline_s:.0f} s; it was ended") from error
    if done.returncode not in ENDED:
        said = [line for line in done.stderr.splitlines() if line.strip()]
        problem = said[-1].removeprefix("ERROR: ").removeprefix("main.pl: ") if said else "no reason was told"
        raise BadInput(OF_INSTEAD.sub("'", problem.replace("--instead", "--settings")))


def _check_same_way(done: WhatIf) -> None:
    was, other = (result.steps for result in done.results)
    for number, (one, two) in enumerate(zip(was[: done.at - 1], other, strict=False), start=1):
        if not _same(one, two):
            raise BadInput(
                f"{done.folders[1]}: it went another way already at i{number}: the session was of another"
                " version, or its scene has changed; do it again first"
            )
    if len(other) < done.at:
        raise BadInput(f"{done.folders[1]}: it ended before i{done.at}; do the session again first")


def _same(one: StepRecord, two: StepRecord) -> bool:
    if one.settings is None or two.settings is None:
        return one.settings is two.settings
    errors = one.rms_px is two.rms_px is None or math.isclose(
        one.rms_px or 0.0, two.rms_px or 0.0, abs_tol=SAME_PX
    )
    return words.same_settings(one.settings, two.settings) and one.decision == two.decision and errors


def _end(result: Result) -> dict[str, str]:
    error = result.error
    return {
        "status": result.status,
        "images": f"{len(result.steps)}, {len(result.kept)} kept",
        "merit": words.pixels(result.merit_px) if result.pose else words.NONE,
        "RMS error": words.pixels(result.rms_px),
        "true error": f"{words.length(error.translation_m)}, {words.angle(error.rotation_deg)}"
        if error
        else words.NONE,
    }


def print_what_if(done: WhatIf) -> None:
    """The table for a terminal."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"What if i{done.at} had been taken otherwise?", title_justify="left")
    table.add_column("")
    table.add_column("as it was", ratio=1)
    table.add_column("what if", ratio=1)
    for image, *steps in done.rows():
        cells = [_cell(step, done.asked(side, step)) for side, step in enumerate(steps)]
        table.add_row(image, *cells, end_section=True)
    for name, *values in done.ends():
        table.add_row(name, *values)
    Console().print(table)


def _cell(step: StepRecord | None, asked: str) -> str:
    if step is None:
        return words.NONE
    merit = f"merit {words.pixels(step.merit)}" if step.pose else "no pose"
    return "\n".join(filter(None, (asked, step.settings_words, f"{step.decision}, {merit}")))


def write_what_if(done: WhatIf) -> Path:
    """Write whatif.html into the other way's folder; its path.

    Raises
    ------
    BadInput : it cannot be written.
    """
    from report.fragments import environment, style
    from report.pictures import data_uri, read_picture
    from report.scene import known_lights, read_scene
    from report.story import step_view
    from report.strokes import strokes_of, support_of

    scenes = [read_scene(folder) for folder in done.folders]

    def view(side: int, step: StepRecord | None) -> object:
        if step is None:
            return None
        folder, result, scene = done.folders[side], done.results[side], scenes[side]
        picture = read_picture(folder, step.image, scene)
        strokes = strokes_of(scene, step.pose, support_of(step.lines))
        uri = "" if picture.pixels is None else data_uri(picture.pixels, False)
        lights = known_lights(result, scene)
        shown = step_view(step, done.at, picture, strokes, lights, result.steps)
        return shown, uri, step.merit, done.asked(side, step)

    camera = scenes[0].camera
    html = (
        environment()
        .get_template("whatif.html.j2")
        .render(
            style=style("live.css"),
            done=done,
            rows=[
                (image, [view(side, step) for side, step in enumerate(steps)])
                for image, *steps in done.rows()
            ],
            size=(camera.width, camera.height) if camera else (4, 3),
            words=words,
            reports=[
                os.path.relpath(file, done.folders[1]) if file.is_file() else ""
                for file in (folder / "report.html" for folder in done.folders)
            ],
        )
    )
    path = done.folders[1] / "whatif.html"
    try:
        with replaced(path) as new:
            new.write_text(html, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror})") from error
    return path
