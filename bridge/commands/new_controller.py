"""`python -m bridge new-controller`: a strategy of one's own, with its tests and a plan to compare it."""

from __future__ import annotations

import os
import re
from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.errors import BadInput, DeviceError

ROOT = Path(__file__).resolve().parents[2]
FILES = {
    "strategy.pl": "{name}.pl",
    "test.plt": "{name}.plt",
    "test.py": "test_{name}.py",
    "plan.toml": "plan.toml",
}
"""Template, and the file that is made of it."""


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("name", metavar="NAME", help="Of the strategy, and of the new folder it goes into.")


def run(options: Namespace) -> None:
    """Make the files and say what can be done with them."""
    folder = make_controller(options.name)
    made = folder.name
    session, python = _commands()
    told = {
        f"{made}.pl": f"the strategy:  {session} --controller {made}/{made}.pl",
        f"{made}.plt": f"in a simulated world:  swipl -g run_tests -t halt {made}/{made}.plt",
        f"test_{made}.py": f"against mock servers:  {python} -m pytest {made}",
        "plan.toml": f"beside others:  {python} -m experiments run {made}/plan.toml --out {made}/results",
    }
    for file, what in told.items():
        print(f"{made}/{file:<{len(made) + 8}}  {what}")


def _commands() -> tuple[str, str]:
    """How a session, and Python, are run from here: a checkout, or a folder of an installed copy's user."""
    checkout = Path("main.pl").exists()
    return ("swipl main.pl", ".venv/bin/python") if checkout else ("lights-and-camera", "python")


def make_controller(name: str) -> Path:
    """Make the folder `name` in the working directory; the folder.

    Raises
    ------
    BadInput
        The name cannot be a strategy's, or is taken.
    DeviceError
        The folder cannot be written.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    if not re.fullmatch("[a-z][a-z0-9_]{0,39}", name):
        raise BadInput(
            f"A strategy cannot be called {name!r}.",
            "Use up to 40 lower-case letters, digits and underscores, a letter first.",
        )
    if (ROOT / "domain" / "controllers" / f"{name}.pl").exists():
        raise BadInput(f"There is a strategy {name} already, in domain/controllers.", "Use another name.")
    folder = Path(name)
    root = Path(os.path.relpath(ROOT, folder)) if Path.cwd().is_relative_to(ROOT) else ROOT
    templates = Environment(
        loader=FileSystemLoader(ROOT / "bridge" / "new_controller"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    session, python = _commands()
    told = {"name": name, "folder": folder, "root": root, "session": session, "python": python}
    try:
        folder.mkdir()
        for template, file in FILES.items():
            text = templates.get_template(f"{template}.j2").render(told)
            (folder / file.format(name=name)).write_text(text)
    except FileExistsError:
        raise BadInput(
            f"There is a folder or file {name} here already.", "Use another name, or remove it."
        ) from None
    except OSError as error:
        raise DeviceError(
            f"Cannot write {folder}: {error.strerror}.", "Make room, or go to another folder."
        ) from None
    return folder
