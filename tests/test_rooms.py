"""docs/architecture.md's table of rooms is the tree's, and nothing imports what it may not know of."""

import ast
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "architecture.md"
ROW = re.compile(r"^\| `(?P<room>[\w/.]+)` \| (?P<what>[^|]+) \|(?P<may>[^|]*)\|$", re.MULTILINE)
TOP = (
    "bridge", "domain", "experiments", "geometry", "image_server", "indigolog", "numerics", "report",
    "session", "stack", "vision_server",
)  # fmt: skip
USE = re.compile(r"""^:- (?:re_?export|use_module|autoload)\(\s*('[^']+'|[\w/.]+)""", re.MULTILINE)
LIBRARY = re.compile(r"^:- (?:re_?export|use_module|autoload)\(library", re.MULTILINE)
LARGEST_PROLOG_CYCLE = 3


@cache
def rooms() -> dict[str, frozenset[str]]:
    """What each room may import, from the page; a name with `/*` stands for all rooms under it."""
    rows = {match["room"].rstrip("/"): match["may"] for match in ROW.finditer(PAGE.read_text())}
    allowed = {}
    for room, may in rows.items():
        names = re.findall(r"`([\w/.*]+)`", may)
        wide = {name[:-2] for name in names if name.endswith("/*")}
        under = {other for other in rows for one in wide if other.startswith(one + "/")}
        allowed[room] = frozenset({name.rstrip("/") for name in names} | wide | under)
    return allowed


def room_of(file: Path) -> str | None:
    """The innermost room that a file lies in."""
    path = file.relative_to(ROOT)
    names = [str(path), *(str(parent) for parent in path.parents)]
    return next((name for name in names if name in rooms()), None)


def sources(suffix: str) -> list[Path]:
    """Source files of the rooms."""
    files = [file for top in TOP for file in (ROOT / top).rglob(f"*{suffix}")]
    if suffix == ".pl":
        files.append(ROOT / "main.pl")
    return sorted(file for file in files if "__pycache__" not in file.parts)


def module_file(name: str) -> Path | None:
    """The file of a Python module of ours; a package's is its `__init__.py`."""
    path = ROOT / name.replace(".", "/")
    if path.with_suffix(".py").is_file():
        return path.with_suffix(".py")
    return path / "__init__.py" if path.is_dir() and path.is_relative_to(ROOT) else None


@cache
def parsed(file: Path) -> tuple[list[ast.stmt], list[ast.Import | ast.ImportFrom], set[int]]:
    """Statements of a Python file, all of its imports, and which of these are for types alone."""
    tree = ast.parse(file.read_text())
    nodes = list(ast.walk(tree))
    typing = {
        id(node)
        for test in nodes
        if isinstance(test, ast.If) and ast.unparse(test.test).endswith("TYPE_CHECKING")
        for node in ast.walk(test)
    }
    return tree.body, [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)], typing


def python_imports(file: Path, late: bool) -> Iterator[Path]:
    """Files of ours that a Python file imports; `late` adds imports in functions."""
    statements, anywhere, typing = parsed(file)
    for node in anywhere if late else statements:
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and id(node) not in typing:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            if name.split(".")[0] not in TOP:
                continue
            found = module_file(name) or module_file(name.rpartition(".")[0])
            if found is not None and found != file:
                yield found


def prolog_imports(file: Path) -> Iterator[Path]:
    """Files of ours that a Prolog file loads."""
    for match in USE.finditer(file.read_text()):
        if LIBRARY.match(match[0]):
            continue
        path = (file.parent / match[1].strip("'")).resolve()
        found = path if path.suffix == ".pl" else path.with_name(path.name + ".pl")
        assert found.is_file(), f"{file.relative_to(ROOT)} loads {match[1]}, which is not there"
        yield found


@cache
def graph(suffix: str, late: bool) -> dict[Path, set[Path]]:
    """Which file imports which."""
    if suffix == ".py":
        return {file: set(python_imports(file, late)) for file in sources(".py")}
    return {file: set(prolog_imports(file)) for file in sources(".pl")}


def cycles(edges: dict[Path, set[Path]]) -> list[list[str]]:
    """Groups of files that import each other in a ring (strongly connected components; Tarjan 1972)."""
    order: dict[Path, int] = {}
    low: dict[Path, int] = {}
    stack: list[Path] = []
    found: list[list[str]] = []

    def visit(node: Path) -> None:
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in edges.get(node, ()):
            if other not in order:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], order[other])
        if low[node] == order[node]:
            ring = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(ring) > 1:
                found.append(sorted(str(file.relative_to(ROOT)) for file in ring))

    for node in edges:
        if node not in order:
            visit(node)
    return found


def test_every_room_is_there_and_every_folder_has_one() -> None:
    assert [room for room in rooms() if not (ROOT / room).exists()] == []
    homeless = [file for suffix in (".py", ".pl") for file in sources(suffix) if room_of(file) is None]
    assert homeless == []
    folders = {file.parent.relative_to(ROOT) for suffix in (".py", ".pl") for file in sources(suffix)}
    unnamed = {str(folder) for folder in folders if str(folder) not in rooms() and folder != Path()}
    assert unnamed == set()


@pytest.mark.parametrize("suffix", [".py", ".pl"])
def test_rooms_import_only_what_they_may_know_of(suffix: str) -> None:
    wrong = []
    for file, others in graph(suffix, late=True).items():
        here = room_of(file)
        for other in others:
            there = room_of(other)
            if here is not None and there is not None and there != here and there not in rooms()[here]:
                wrong.append(f"{file.relative_to(ROOT)} ({here}) imports {other.relative_to(ROOT)} ({there})")
    assert not wrong, "\n" + "\n".join(wrong)


def test_rooms_know_of_no_more_than_they_import() -> None:
    used = {
        (room_of(file), room_of(other))
        for suffix in (".py", ".pl")
        for file, others in graph(suffix, late=True).items()
        for other in others
    }
    rows = ROW.finditer(PAGE.read_text())
    named = {(row["room"], other) for row in rows for other in re.findall(r"`([\w/.]+)`", row["may"])}
    assert named - used == set()


def test_no_python_modules_import_each_other_in_a_ring() -> None:
    assert cycles(graph(".py", late=False)) == []


def test_no_large_ring_of_prolog_modules() -> None:
    assert [ring for ring in cycles(graph(".pl", late=True)) if len(ring) > LARGEST_PROLOG_CYCLE] == []


def test_a_ring_is_found() -> None:
    first, second, third = (ROOT / name for name in "abc")
    assert cycles({first: {second}, second: {first, third}, third: set()}) == [["a", "b"]]


def test_files_that_the_page_names_are_there() -> None:
    path = re.compile(rf"`((?:[\w-]+/)+[\w-]+\.(?:py|pl|md|json)|(?:{'|'.join(TOP)})/[\w/]*)`")
    named = path.findall(PAGE.read_text())
    assert len(named) > 30
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_modules_are_named_with_the_room_that_they_are_in() -> None:
    """A text that says `pose.spun` is true while spun.py lies in a folder `pose`."""
    files = [*sources(".py"), *sources(".pl")]
    folders: dict[str, set[str]] = {}
    for file in files:
        folders.setdefault(file.stem, set()).add(file.parent.name)
    known = {folder for some in folders.values() for folder in some}
    named = re.compile(r"`(?:[\w/]*/)?(\w+)[./](\w+)(?:\.py|\.pl)?`")
    stale = [
        f"{file.relative_to(ROOT)}: {match[0]}"
        for file in [*files, *(ROOT / "docs").glob("*.md")]
        for match in named.finditer(file.read_text())
        for room, module in [match.groups()]
        if room in known and module not in known and room not in folders.get(module, {room})
    ]
    assert stale == []


def test_contracts_are_cited_where_they_are() -> None:
    """No source cites a page that the repository does not hold."""
    cited = re.compile(r"docs/([\w-]+\.md)")
    for file in [*sources(".py"), *sources(".pl")]:
        text = file.read_text()
        assert "DESIGN" not in text, f"{file.relative_to(ROOT)} cites a page that is not here"
        missing = [page for page in cited.findall(text) if not (ROOT / "docs" / page).is_file()]
        assert missing == [], f"{file.relative_to(ROOT)} cites {missing}"


def test_every_package_that_is_required_is_imported_by_a_room() -> None:
    """What only tests or benchmarks import is an extra of theirs, and does not come with an installation."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    required = {re.split(r"[<>=]", one)[0].lower() for one in project["dependencies"]}
    imports = [node for file in sources(".py") for node in parsed(file)[1]]
    modules = {one.name for node in imports if isinstance(node, ast.Import) for one in node.names}
    modules |= {node.module or "" for node in imports if isinstance(node, ast.ImportFrom)}
    tops, homes = {name.split(".")[0] for name in modules}, packages_distributions()
    imported = {home.lower().replace("_", "-") for top in tops for home in homes.get(top, [top])}
    assert required - imported == set()


def test_no_test_file_lends_to_another() -> None:
    """What several files of tests need has a file of its own, which is not called `test_`."""
    lent = re.compile(r"^(?:from|import) tests\.\S*\btest_\w+", re.MULTILINE)
    assert [str(file) for file in (ROOT / "tests").rglob("*.py") if lent.search(file.read_text())] == []
