"""A file that is replaced as a whole."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from bridge.whole_file import replaced


def test_the_old_file_is_there_until_the_new_one_is_written(tmp_path: Path) -> None:
    file = tmp_path / "result"
    file.write_text("old")
    with replaced(file) as new:
        new.write_text("new")
        assert file.read_text() == "old"
    assert file.read_text() == "new"
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("error", [OSError("disk full"), KeyboardInterrupt()])
def test_what_fails_in_between_leaves_the_old_file_alone(tmp_path: Path, error: BaseException) -> None:
    file = tmp_path / "result"
    file.write_text("old")
    with pytest.raises(type(error)), replaced(file) as new:
        new.write_text("half")
        raise error
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_a_file_that_was_not_written_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(OSError), replaced(tmp_path / "result"):
        pass


def test_of_two_that_write_at_once_each_writes_its_own_and_the_last_one_stays(tmp_path: Path) -> None:
    file = tmp_path / "result"

    def write_other() -> None:
        with replaced(file) as new:
            new.write_text("other")

    with ThreadPoolExecutor(1) as thread, replaced(file) as new:
        new.write_text("one")
        thread.submit(write_other).result()
        assert file.read_text() == "other"
    assert file.read_text() == "one"
    assert list(tmp_path.iterdir()) == [file]
