"""The tumbling satellite: it turns, the sun goes round, lamps switch; its picture is of what was tracked."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks import tumbling
from benchmarks.films import PERIOD_S
from image_server.simulator.simulator import Simulator


def test_target_and_light_change_with_each_frame() -> None:
    device = Simulator("satellite", tumbling.tumbling(), 3)
    (first, before), (second, after) = tumbling.taken(device, 2)
    turned = np.linalg.norm(tumbling.SPIN_DEG_PER_S) * PERIOD_S
    assert after.error_to(before).rotation_deg == pytest.approx(turned, abs=0.01)
    assert second.mean() > 1.1 * first.mean()  # the sun alone, then a lamp as well


@pytest.mark.slow
def test_the_picture_has_every_frame_that_is_due_and_the_numbers_are_of_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tumbling, "EVERY", 2)
    monkeypatch.setattr(tumbling, "COLUMNS", 2)
    tumbling.main(tmp_path / "out.jpg", tmp_path / "out.mp4", 3)
    told = json.loads(capsys.readouterr().out)
    assert (told["frames"], told["value"], told["sure_and_wrong"], told["lost"]) == (3, 3, 0, 0)
    picture = cv2.imread(str(tmp_path / "out.jpg"))
    assert picture is not None
    assert picture.shape == (240, 640, 3)
    film = cv2.VideoCapture(str(tmp_path / "out.mp4"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == 3
