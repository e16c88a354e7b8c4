"""Make pages from the docstrings of rooms: `python setup/python-pages.py OUT ROOM...`; a warning ends it."""

import importlib
import inspect
import os
import pkgutil
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
NOT_PYTHON = "!bridge.zmq4pl"  # a library of C for Prolog


def modules(rooms: list[str]) -> Iterator[ModuleType]:
    """Every module of these rooms."""
    for room in rooms:
        package = importlib.import_module(room)
        yield package
        for found in pkgutil.walk_packages(package.__path__, f"{room}."):
            if not found.name.endswith("__main__") and found.name != NOT_PYTHON.removeprefix("!"):
                yield importlib.import_module(found.name)


def resolve_named_tuples(module: ModuleType) -> None:
    """Give the fields of named tuples their types: pdoc looks for them in a module that has none."""
    from pdoc.doc_types import resolve_annotations

    for name, found in inspect.getmembers(module, inspect.isclass):
        if issubclass(found, tuple) and hasattr(found, "_fields") and found.__module__ == module.__name__:
            new: Any = found.__new__
            new.__annotations__ = resolve_annotations(new.__annotations__, module, None, name)


def main(out: Path, rooms: list[str]) -> None:
    """Write the pages."""
    os.environ["PDOC_ALLOW_EXEC"] = "1"  # pyswip asks swipl where it is
    import pdoc
    import pdoc.render

    sys.path.insert(0, str(ROOT))
    warnings.simplefilter("error")
    for module in modules(rooms):
        resolve_named_tuples(module)
    pdoc.render.configure(docformat="numpy", show_source=False)
    pdoc.pdoc(*rooms, NOT_PYTHON, output_directory=out)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
