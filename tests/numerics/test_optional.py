"""Optional packages are absent for the thread that hides them, and there again afterwards."""

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path

import pytest

from numerics.optional import without


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Two packages that nothing has loaded."""
    for name in ("sought", "looking"):
        (tmp_path / f"{name}.py").write_text(f"import {'sys' if name == 'sought' else 'sought'}\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield
    for name in ("sought", "looking"):
        sys.modules.pop(name, None)


def test_it_is_absent_meanwhile_and_there_afterwards(packages: None) -> None:
    finders = list(sys.meta_path)
    with without("sought"), pytest.raises(ImportError, match="'sought': it is hidden"):
        import_module("looking")
    assert sys.meta_path == finders
    assert import_module("looking").sought.__name__ == "sought"


def test_other_threads_find_it_and_so_does_who_has_it(packages: None) -> None:
    with without("sought"), ThreadPoolExecutor(1) as other:
        assert other.submit(import_module, "sought").result().__name__ == "sought"
        assert import_module("sought").__name__ == "sought"


def test_it_is_there_again_after_an_error(packages: None) -> None:
    with pytest.raises(ZeroDivisionError), without("sought"):
        _ = 1 / 0
    assert import_module("sought").__name__ == "sought"
