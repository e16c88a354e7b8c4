"""The page of every kind of session: what it says."""

import json
import os
import shlex
from pathlib import Path
from typing import Any

import cv2
import pytest

from bridge import __version__
from bridge.errors import BadInput
from geometry.model import Model, load_model
from report import scene
from report.page import write_report
from tests.report.pages import Page, changed, page_of
from tests.report.run_folders import RunMaker

ONE_OFF = {"rotation_deg": 3.0, "translation_m": 0.02, "translation_fraction_of_range": 0.05}


@pytest.mark.parametrize(
    ("fields", "headline"),
    [
        ({"status": "converged"}, "Pose found"),
        ({"status": "exhausted"}, "No certain pose"),
        ({"status": "stopped"}, "Stopped early"),
        ({"status": "converged", "error": ONE_OFF}, "A wrong pose was taken for right"),
        ({"status": "exhausted", "pose": None, "covariance": None, "error": None}, "No pose"),
        ({"status": "stopped", "pose": None}, "Stopped early, with no pose"),
        ({"status": "aborted by hand"}, "Session ended: aborted by hand"),
    ],
)
def test_the_headline_says_what_came_of_it(make_run: RunMaker, fields: dict[str, Any], headline: str) -> None:
    page = page_of(make_run(**fields))
    assert headline in page.text


@pytest.mark.parametrize("status", ["converged", "exhausted"])
def test_how_a_round_target_is_turned_is_said_to_be_open(make_run: RunMaker, status: str) -> None:
    page = page_of(make_run(status=status, free=[[0.0, 0.6, 0.8]]))
    assert "No image clearly tells how it is turned about its axis (0.00, 0.60, 0.80)." in page.text


@pytest.mark.parametrize("status", ["converged", "exhausted", "stopped"])
def test_zero_steps(make_run: RunMaker, status: str) -> None:
    page = page_of(make_run(steps=0, status=status))
    assert "No image was taken." in page.text
    assert page.uses == []


@pytest.mark.parametrize(
    ("decision", "words"),
    [("discard", "the strategy discarded every image that shows one"), ("keep", "found and lost again")],
)
def test_a_pose_that_was_found_and_not_kept_is_no_lack_of_one(
    make_run: RunMaker, decision: str, words: str
) -> None:
    folder = make_run(status="exhausted", pose=None, covariance=None, error=None)
    steps = json.loads((folder / "result.json").read_text())["steps"]
    changed(folder, steps=[step | {"decision": decision} for step in steps])
    text = page_of(folder).text
    assert words in text
    assert "gave a pose" not in text and "gave no pose" not in text


def test_a_first_iteration_cut_short(make_run: RunMaker) -> None:
    page = page_of(make_run(steps=0, status="stopped", iterations=1, message="The vision server died."))
    assert "before its first iteration was complete" in page.text
    assert "Images 1 none judged" in page.text
    assert "The vision server died." in page.text


def test_the_story_is_told(make_run: RunMaker) -> None:
    page = page_of(make_run())
    for words in (
        "left 1 right 0 top 7, 1/60 s, f/4",
        "dim, from the top",
        "reason <2> & more",
        "discarded",
        "7/7",
        "1/60 s",
        "f/4",
        "swipl main.pl --seed 1",
        "0.20 mm",
        "threshold 1 px",
    ):
        assert words in page.text
    assert sorted(set(page.uses)) == ["#image-i1", "#image-i2", "#image-i3"]


def test_time_goes_to_its_parts_and_the_rest(make_run: RunMaker) -> None:
    text = page_of(make_run()).text
    assert "matching 0.75 s 38 %" in text
    assert "other 0.25 s 12 %" in text


def test_standard_deviations_are_of_the_targets_origin(make_run: RunMaker, bench: Any) -> None:
    # 0.1 mrad about x moves an origin 0.35 m ahead by 0.035 mm, beside 0.1 mm of its own: 0.106 mm.
    text = page_of(make_run()).text
    assert "± 0.11 mm" in text
    assert "± 0.0057°" in text


def test_overlays_are_written_as_files(make_run: RunMaker) -> None:
    folder = make_run()
    write_report(folder)
    for number in (1, 2, 3):
        overlay = cv2.imread(str(folder / "images" / f"i{number}-overlay.png"))
        assert overlay is not None
        assert overlay.shape == (240, 320, 3)
        assert (overlay[:, :, 0] != overlay[:, :, 2]).any()


def test_a_missing_image_is_said(make_run: RunMaker) -> None:
    folder = make_run()
    (folder / "images" / "i2.png").unlink()
    (folder / "images" / "i3.png").write_bytes(b"no image")
    text = page_of(folder).text
    assert "The file images/i2.png is missing." in text
    assert "images/i3.png is no readable image." in text
    assert "2 images of this session cannot be shown." in text
    assert not (folder / "images" / "i2-overlay.png").exists()


def test_an_image_of_another_size_is_said(make_run: RunMaker, bench: Any) -> None:
    folder = make_run()
    assert cv2.imwrite(str(folder / "images" / "i1.png"), bench.image()[:100])
    assert "images/i1.png is 320×100, its camera 320×240." in page_of(folder).text


def test_no_images_folder_at_all(make_run: RunMaker) -> None:
    folder = make_run()
    for path in (folder / "images").iterdir():
        path.unlink()
    (folder / "images").rmdir()
    text = page_of(folder).text
    assert "There is no images/stack.toml" in text
    assert "3 images of this session cannot be shown." in text
    assert "Pose found" in text


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[camera]", "[camera", "cannot be read"),
        ("width = 320", "", "camera"),
        ("cube.cao", "gone.cao", "gone.cao"),
    ],
)
def test_a_stack_file_that_cannot_be_used_is_said(make_run: RunMaker, old: str, new: str, words: str) -> None:
    folder = make_run()
    path = folder / "images" / "stack.toml"
    path.write_text(path.read_text().replace(old, new))
    text = page_of(folder).text
    assert words in text
    assert "no overlays" in text


def test_a_step_without_a_pose(make_run: RunMaker) -> None:
    folder = make_run()
    steps = json.loads((folder / "result.json").read_text())["steps"]
    steps[0] |= {"pose": None, "rms_px": None, "merit": 100.0, "error": None}
    changed(folder, steps=steps)
    text = page_of(folder).text
    assert "no pose yet" in text
    assert "100 px" not in text
    assert not (folder / "images" / "i1-overlay.png").exists()


def test_only_what_the_design_promises(make_run: RunMaker) -> None:
    folder = make_run()
    result = json.loads((folder / "result.json").read_text())
    for key in ("threshold_px", "merit_px", "command", "error"):
        del result[key]
    for step in result["steps"]:
        for key in ("pose", "merit", "supported_fraction", "settings_words", "error"):
            del step[key]
    (folder / "result.json").write_text(json.dumps(result))
    text = page_of(folder).text
    assert "settings not recorded" in text
    assert "command line was not recorded" in text


def test_the_session_can_be_done_again_by_what_the_page_says(make_run: RunMaker, tmp_path: Path) -> None:
    folder = make_run().rename(tmp_path / "it's here")
    assert "--again" not in page_of(folder).text
    (folder / "session.pl").write_text("version(1).\n")
    text = page_of(folder).text
    assert f"swipl main.pl --again {shlex.quote(str(folder))}" in text
    assert "begun with swipl main.pl --seed 1" in text


def test_support_of_lines_is_shown(make_run: RunMaker) -> None:
    folder = make_run(lines=[{"line": 0, "support": 1.0}, {"line": 1, "support": 0.1}])
    page = page_of(folder)
    assert "not supported" in page.text
    assert 'class="unsupported"' in (folder / "report.html").read_text()


def test_an_approach_has_its_table(make_run: RunMaker, bench: Any) -> None:
    covariance = [[1e-8 if i == j else 0.0 for j in range(6)] for i in range(6)]
    holds = [
        {
            "range_m": 1.5,
            "status": "fixed",
            "rms_px": 0.5,
            "pose": bench.pose.to_dict(),
            "covariance": covariance,
        },
        {"range_m": 0.8, "status": "aborted", "rms_px": None, "pose": None},
    ]
    page = page_of(make_run(status="exhausted", holds=holds))
    assert "Approach aborted at 0.8 m" in page.text
    assert "1 of 2 hold points passed" in page.text
    assert "1.5 m fixed 0.50 px" in page.text
    holds[1] |= {"status": "reached", "pose": bench.pose.to_dict(), "uncertainty": 2e-4}
    page = page_of(make_run(name="second", holds=holds))
    assert "Approach reached 0.8 m" in page.text


def test_an_approach_that_stopped_between_hold_points_shows_what_was_fixed(
    make_run: RunMaker, bench: Any
) -> None:
    folder = make_run()
    steps = json.loads((folder / "result.json").read_text())["steps"]
    fixed = {
        "range_m": 1.5, "status": "fixed", "rms_px": 0.5, "merit": 0.7, "pose": bench.pose.to_dict(),
        "error": {"rotation_deg": 0.1, "translation_m": 3e-4, "translation_fraction_of_range": 2e-4},
    }  # fmt: skip
    for step, hold in zip(steps, (1, 1, 2), strict=True):
        step["hold"] = hold
    steps[2]["pose"] = None
    here = {"pose": None, "covariance": None, "rms_px": None, "merit_px": 100.0, "error": None, "lines": []}
    changed(folder, status="stopped", steps=steps, holds=[fixed], planned_holds_m=[1.5, 1.0, 0.7], **here)
    page = page_of(folder)
    assert "1 of 3 hold points passed; the last was at 1.5 m." in page.text
    assert "Best estimate over image i1" in page.text
    assert "no pose was found since" in page.text
    assert page.text.count("0.30 mm") == 2  # in its tile and in the approach's table
    changed(folder, holds=[], planned_holds_m=[1.5, 1.0, 0.7])
    assert "None of 3 hold points was passed; the first is at 1.5 m." in page_of(folder).text


def test_many_steps_and_lights(make_run: RunMaker) -> None:
    folder = make_run(steps=40)
    steps = json.loads((folder / "result.json").read_text())["steps"]
    for step in steps:
        step["settings"]["lights"] = [3, 255]
    changed(folder, steps=steps, lights=[{"name": "ring", "levels": 4}, {"name": "spot", "levels": 256}])
    text = page_of(folder).text
    assert "3/3" in text
    assert "255/255" in text


def test_an_unknown_field_is_no_trouble(make_run: RunMaker) -> None:
    assert "Pose found" in page_of(make_run(versions={"anything": [1, 2]})).text


def test_the_same_folder_gives_the_same_page(make_run: RunMaker) -> None:
    folder = make_run()
    first = write_report(folder).read_bytes()
    assert write_report(folder).read_bytes() == first


def test_an_image_id_that_leaves_the_folder_is_refused(make_run: RunMaker) -> None:
    folder = make_run()
    steps = json.loads((folder / "result.json").read_text())["steps"]
    steps[0]["image"] = "../../elsewhere"
    changed(folder, steps=steps)
    with pytest.raises(BadInput, match="plain file name"):
        write_report(folder)


def test_other_settings_than_were_asked_for_are_noted(make_run: RunMaker) -> None:
    folder = make_run()
    steps = json.loads((folder / "result.json").read_text())["steps"]
    steps[1]["asked"] = steps[1]["settings"] | {"lights": [3, 3, 3]}
    changed(folder, steps=steps)
    page = " ".join(Page(write_report(folder).read_text()).words)
    others = "i2 (left 2 right 0 top 7, 1/60 s, f/4)"
    assert f"Taken under other settings than were asked for: {others}." in page


def test_a_result_of_another_format_is_refused_in_one_line(make_run: RunMaker) -> None:
    page_of(make_run(version=1))
    folder = make_run(name="newer", version=2, pose={"quaternion": [1, 0, 0, 0]})
    with pytest.raises(
        BadInput, match=r"result\.json: of format 2, and this version reads format 1"
    ) as error:
        write_report(folder)
    assert "\n" not in str(error.value)


def test_the_model_is_read_once_while_its_file_stays(
    make_run: RunMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = make_run()
    read: list[Path] = []

    def reading(file: Path, unit: str) -> Model:
        read.append(file)
        return load_model(file, unit)

    monkeypatch.setattr(scene, "load_model", reading)
    first = scene.read_scene(folder)
    assert scene.read_scene(folder).model is first.model and len(read) == 1
    model = folder / "images" / "cube.cao"
    os.utime(model, ns=(0, 0))
    scene.read_scene(folder)
    assert len(read) == 2
    model.unlink()
    assert scene.read_scene(folder).notes


def test_the_version_is_in_the_head(make_run: RunMaker) -> None:
    assert f"version {__version__}" in write_report(make_run()).read_text()
