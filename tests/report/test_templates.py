"""The pages' templates."""

from pathlib import Path

import pytest

from report import fragments


@pytest.mark.parametrize("there", [True, False])
def test_templates_are_compiled_once_where_that_can_be_kept(
    there: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "kept"
    if there:
        kept.mkdir()
    monkeypatch.setattr(fragments, "COMPILED", kept)
    fragments.environment.cache_clear()
    try:
        first = fragments.live_page("token")
        written = {file.name: file.stat().st_mtime_ns for file in kept.glob("*")}
        assert bool(written) == there
        fragments.environment.cache_clear()
        assert fragments.live_page("token") == first
        assert {file.name: file.stat().st_mtime_ns for file in kept.glob("*")} == written
    finally:
        fragments.environment.cache_clear()
