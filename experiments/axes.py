"""What may stand on the axes of a plan: lists of numbers, strategies, and folders of stacks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from glob import glob
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.command_line import MOST_SEED
from bridge.errors import BadInput
from experiments.version import ROOT
from stack.format import STACK_FILE

if TYPE_CHECKING:
    from experiments.kinds import Kind

CONTROLLERS = ROOT / "domain" / "controllers"
MOST_NUMBERS = 10_000_000  # of an axis, chosen by hand: more is a slip of the pen


def numbers(axis: str, given: Sequence[int] | int | str) -> list[int]:
    """Numbers as a plan says them: one, a list, or words such as "1-5" and "1,2,7-9".

    Raises
    ------
    BadInput : what is no number, negative, more than a table holds, or there twice.
    """
    if isinstance(given, str):
        found: list[int] = []
        for part in given.replace(" ", "").split(","):
            first, dash, last = part.partition("-")
            if not first.isdecimal() or (dash and not last.isdecimal()):
                raise BadInput(f"{axis} = {given!r} says no numbers.", 'Write "1-5", "1,2,7" or [1, 2, 7].')
            if int(last or first) < int(first):
                raise BadInput(f"{axis} = {given!r} runs backwards.", "Write the smaller number first.")
            if int(last or first) - int(first) >= MOST_NUMBERS:
                raise BadInput(f"{axis} = {given!r} says more than {MOST_NUMBERS} numbers.")
            found += range(int(first), int(last or first) + 1)
    else:
        found = [given] if isinstance(given, int) else list(given)
    if any(number < 0 for number in found):
        raise BadInput(f"{axis} must not be negative.")
    if any(number > MOST_SEED for number in found):
        raise BadInput(f"{axis} must be at most {MOST_SEED}.")
    if len(set(found)) < len(found):
        raise BadInput(f"{axis} = {given!r} says a number twice.")
    return found


def stack_folders(patterns: Sequence[str], here: Path) -> list[Path]:
    """Folders of stacks, by their paths or by patterns such as ``../stacks/*``.

    Raises
    ------
    BadInput : nothing there, or no stack.
    """
    folders = []
    for pattern in patterns:
        found = [here / pattern]
        if not found[0].exists():
            files = glob(f"{pattern}/{STACK_FILE}", root_dir=here)
            found = [(here / file).parent for file in sorted(files)]
        if not found or not all((folder / STACK_FILE).is_file() for folder in found):
            raise BadInput(f"stacks: {pattern!r} is no folder with a {STACK_FILE}.")
        folders += [folder.resolve() for folder in found]
    return folders


def strategies(kind: Kind, words: Sequence[str], here: Path) -> list[tuple[str, str]]:
    """What is compared: controllers by name or Golog file, or what the kind of cell offers instead.

    Raises
    ------
    BadInput : an unknown name.
    """
    if kind.strategies is not None:
        for word in words:
            if not kind.knows(word):
                raise BadInput(f"controllers: {word!r} is not one of {kind.strategies}.")
        return [(word, word) for word in dict.fromkeys(words)]
    named = {file.stem: file for file in sorted(CONTROLLERS.glob("*.pl"))}
    found = []
    for word in words:
        if word not in named and not (here / word).is_file():
            raise BadInput(f"controllers: {word!r} is neither a file nor one of {', '.join(named)}.")
        found.append(Path(word) if word in named else (here / word).resolve())
    return [(name, str(path)) for name, path in unique_names("controller", found)]


def unique_names(what: str, paths: Sequence[Path]) -> list[tuple[str, Path]]:
    """Each path once, with its name alone; with its folder's where two have the same.

    Raises
    ------
    BadInput : two that cannot be told apart.
    """
    paths = list(dict.fromkeys(paths))
    count = Counter(path.name if path.is_dir() else path.stem for path in paths)
    names = []
    for path in paths:
        name = path.name if path.is_dir() else path.stem
        names.append(name if count[name] == 1 else f"{path.parent.name}/{name}")
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise BadInput(f"two files or folders are called {twice!r} as a {what}.", "Rename one.")
    return list(zip(names, paths, strict=True))
