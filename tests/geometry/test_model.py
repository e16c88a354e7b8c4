"""Model files give their wireframe, and bad ones say where they are wrong."""

from pathlib import Path

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.model import find_target, load_model
from geometry.own_axes import own_axes
from geometry.pose import Pose
from geometry.visibility import visible_samples
from tests.vision_server.synthetic import lines_alone

BOX = """V1  # a box
# 3D points
8 // number of points
-1 -1 -1
1 -1 -1   # attributes and comments are left out
-1 1 -1
1 1 -1
-1 -1 1
1 -1 1
-1 1 1
1 1 1
# lines
0
# faces from lines
0
# faces from points
6
4 0 2 3 1 name="back side" useLod=true minPolygonAreaThreshold=2.5
4 4 5 7 6
4 0 1 5 4
4 2 6 7 3
4 0 4 6 2
4 1 3 7 5
0
0
"""


def written(folder: Path, text: str) -> Path:
    file = folder / "thing.cao"
    file.write_text(text)
    return file


def edge_set(model_lines: np.ndarray) -> set[tuple[int, int]]:
    return {(min(a, b), max(a, b)) for a, b in model_lines.tolist()}


def test_faces_give_each_line_once(tmp_path: Path) -> None:
    model = load_model(written(tmp_path, BOX))
    assert model.name == "thing"
    assert len(model.lines) == len(edge_set(model.lines)) == 12
    assert (model.line_faces >= 0).all()
    assert len(model.triangles) == 12
    assert not model.two_sided.any()
    assert not model.smooth.any()


@pytest.mark.parametrize("turned", [(), (0,), (1, 4), (0, 1, 2, 3, 4, 5)])
def test_faces_of_a_closed_surface_look_outwards(tmp_path: Path, turned: tuple[int, ...]) -> None:
    rows = BOX.splitlines()
    first = rows.index("6") + 1
    for k in turned:
        corners = rows[first + k].split()[1:5]
        rows[first + k] = "4 " + " ".join(reversed(corners))
    model = load_model(written(tmp_path, "\n".join(rows)))
    for face, normal in zip(model.faces, model.face_normals, strict=True):
        assert normal @ model.vertices[face].mean(axis=0) > 0.99
    for triangle, face in zip(model.triangles, model.triangle_face, strict=True):
        a, b, c = model.vertices[triangle]
        assert np.cross(b - a, c - a) @ model.face_normals[face] > 0


def test_a_box_without_lid_is_seen_from_both_sides(tmp_path: Path) -> None:
    model = load_model(written(tmp_path, BOX.replace("\n6\n", "\n5\n").replace("4 1 3 7 5\n", "")))
    assert model.two_sided.all()
    assert len(model.lines) == 12
    assert (model.line_faces == -1).any(axis=1).sum() == 4


def test_bodies_that_touch_along_an_edge_are_closed(tmp_path: Path) -> None:
    rows = BOX.splitlines()
    points, faces = rows[3:11], rows[rows.index("6") + 1 :][:6]
    beside = [f"{float(x) + 2:g} {float(y) + 2:g} {z}" for x, y, z in (row.split()[:3] for row in points)]
    number = {0: 3, 4: 7}  # its lower left edge is the upper right one of the first
    again = [
        " ".join(["4", *(str(number.get(int(n), 8 + int(n))) for n in face.split()[1:5])]) for face in faces
    ]
    text = "\n".join(["V1", "16", *points, *beside, "0", "0", "12", *faces, *again])
    model = load_model(written(tmp_path, text))
    assert not model.two_sided.any()
    for face, normal in zip(model.faces, model.face_normals, strict=True):
        middle = model.vertices[face].mean(axis=0)
        assert normal @ (middle - (0.0 if middle[:2].max() < 1.5 else np.array([2.0, 2.0, 0.0]))) > 0.99


def test_the_cut_through_a_flat_surface_is_no_line(tmp_path: Path) -> None:
    text = BOX.replace("\n6\n", "\n7\n").replace("4 4 5 7 6\n", "3 4 5 7\n3 4 7 6\n")
    model = load_model(written(tmp_path, text))
    assert len(model.lines) == 12
    assert (4, 7) not in edge_set(model.lines)


def test_a_drawn_line_is_always_there(tmp_path: Path) -> None:
    text = BOX.replace("# lines\n0\n", "# lines\n2\n4 7\n0 1\n")
    model = load_model(written(tmp_path, text))
    assert len(model.lines) == 13
    assert (4, 7) in edge_set(model.lines)


def test_faces_of_lines(tmp_path: Path) -> None:
    text = "V1\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4\n0 1\n2 1 name=x\n2 3\n3 0\n1\n4 0 1 2 3\n0\n0\n0\n"
    model = load_model(written(tmp_path, text))
    assert len(model.faces) == 1
    assert sorted(model.faces[0].tolist()) == [0, 1, 2, 3]
    assert len(model.lines) == 4


def test_points_that_are_fewer_than_their_count_are_told_where_that_stands(tmp_path: Path) -> None:
    with pytest.raises(
        GeometryError, match=r"thing.cao:\d+: 9 3D points are said, and 8 stand in a line each"
    ):
        load_model(written(tmp_path, BOX.replace("\n8 //", "\n9 //")))


def test_last_sections_may_be_missing(tmp_path: Path) -> None:
    assert len(load_model(written(tmp_path, BOX[: BOX.rindex("0\n0\n")])).lines) == 12


def test_a_cylinder_with_circles_closes(tmp_path: Path) -> None:
    text = "V1\n6\n0 0 0\n0 0 3\n1 0 0\n0 1 0\n1 0 3\n0 1 3\n0\n0\n0\n1\n0 1 0.5\n2\n0.5 0 2 3\n0.5 1 4 5\n"
    model = load_model(written(tmp_path, text))
    assert not model.two_sided.any()
    rims = model.lines[~model.smooth]
    assert len(rims) == 2 * model.smooth.sum()
    np.testing.assert_allclose(np.linalg.norm(model.vertices[rims][:, :, :2], axis=2), 0.5)
    lid = model.vertices[model.triangles]
    volume = np.einsum("ij,ij->i", lid[:, 0], np.cross(lid[:, 1], lid[:, 2])).sum() / 6
    assert volume == pytest.approx(np.pi * 0.25 * 3, rel=0.01)


@pytest.mark.parametrize("unit", ["m", "cm", "mm", "in"])
def test_units(tmp_path: Path, unit: str) -> None:
    factor = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}[unit]
    model = load_model(written(tmp_path, BOX), unit)
    assert model.diameter == pytest.approx(2 * np.sqrt(3) * factor)


ERRORS = [
    ("V2\n", 1, "V1"),
    ("", 1, "V1"),
    ("V1\nmany\n", 2, "number of 3D points"),
    ("V1\n2\n0 0 0\n1 x 0\n", 4, "'x' is not a coordinate"),
    ("V1\n2\n0 0 0\n1 nan 0\n", 4, "'nan' is not a coordinate"),
    ("V1\n2\n0 0 0\n1 0\n", 4, "ends where a coordinate"),
    ("V1\n2\n0 0 0\n1 0 0\n1\n0 2\n", 6, "no point 2"),
    ("V1\n2\n0 0 0\n1 0 0\n1\n1 1\n", 6, "both ends are point 1"),
    (BOX.replace("4 0 2 3 1", "4 0 2 3 8"), 18, "no point 8"),
    (BOX.replace("4 0 2 3 1", "4 0 2 3 0"), 18, "same point twice"),
    (BOX.replace("4 0 2 3 1", "2 0 2"), 18, "at least 3 points"),
    (BOX.replace("4 0 2 3 1", "4 0 -2 3 1"), 18, "'-2' is not the index"),
    (BOX + "7\n", 26, "'7' after the last section"),
    ("V1\n3\n0 0 0\n1 0 0\n2 0 0\n0\n0\n1\n3 0 1 2\n", 9, "no area"),
    ("V1\n2\n0 0 0\n0 0 1\n0\n0\n0\n1\n0 1 -0.5\n", 9, "radius must be positive"),
    ("V1\n3\n0 0 0\n0 0 1\n0 0 2\n0\n0\n0\n0\n1\n1 0 1 2\n", 11, "on one line"),
    ("V1\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3\n0 1\n2 3\n3 0\n1\n3 0 1 2\n", 12, "do not follow"),
    ("V1\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3\n0 1\n1 2\n2 3\n1\n3 0 1 2\n", 12, "do not close"),
]


@pytest.mark.parametrize(("text", "row", "message"), ERRORS)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, text: str, row: int, message: str) -> None:
    file = written(tmp_path, text)
    with pytest.raises(GeometryError, match=message) as error:
        load_model(file)
    assert f"{file}:{row}: " in str(error.value)


def test_a_text_in_utf_16_is_read(tmp_path: Path) -> None:
    file = tmp_path / "cube.cao"
    file.write_text(find_target("cube").read_text(), encoding="utf-16")
    assert len(load_model(file).faces) == 6


def test_a_model_without_faces_and_lines_is_refused(tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match="no faces, and no lines"):
        load_model(written(tmp_path, "V1\n2\n0 0 0\n1 0 0\n0\n0\n0\n"))


def test_other_bad_files(tmp_path: Path) -> None:
    for name in ("none.cao", "cube"):
        with pytest.raises(GeometryError, match=f"{name} does not exist"):
            load_model(tmp_path / name)
    document = tmp_path / "part.wrl"
    document.touch()
    with pytest.raises(GeometryError, match=r"unknown kind '\.wrl'; use one of .*\.stl.*MeshLab and Blender"):
        load_model(document)
    with pytest.raises(GeometryError, match="unknown unit"):
        load_model(written(tmp_path, BOX), "furlong")
    broken = tmp_path / "broken.ply"
    broken.write_text("not a mesh")
    with pytest.raises(GeometryError, match=r"broken\.ply"):
        load_model(broken)


@pytest.mark.parametrize("name", ["cube", "fixture", "satellite"])
def test_named_targets_are_closed_solids(name: str) -> None:
    model = load_model(find_target(name))
    assert model.name == name
    assert not model.two_sided.any()
    assert 0.2 < model.diameter < 1.0


def test_find_target_takes_files_and_lists_names(tmp_path: Path) -> None:
    file = written(tmp_path, BOX)
    assert find_target(str(file)) == file
    step = tmp_path / "part.step"
    step.touch()
    with pytest.raises(GeometryError, match=r"unknown kind '\.step'.*every CAD program exports STL"):
        load_model(find_target(str(step)))
    with pytest.raises(GeometryError, match="cube, fixture, satellite"):
        find_target("teapot")
    with pytest.raises(GeometryError, match="does not exist"):
        find_target("teapot.cao")
    with pytest.raises(GeometryError, match="unknown target"):
        find_target("../targets/cube")


def test_recorded_models_can_be_read(shared_data: Path) -> None:
    files = sorted(shared_data.rglob("*.cao"))
    assert files
    for file in files:
        assert len(load_model(file).lines) >= 12


def test_step_files_are_told_what_to_export(tmp_path: Path) -> None:
    (tmp_path / "part.step").write_text("ISO-10303-21;")
    with pytest.raises(GeometryError, match="exports STL"):
        load_model(tmp_path / "part.step")


def test_nothing_hides_the_lines_of_a_model_of_lines_alone(tmp_path: Path) -> None:
    path = lines_alone(load_model(written(tmp_path, BOX)), tmp_path)
    model = load_model(path)
    assert not model.faces
    far = Pose(np.array([0.3, 0.4, 0.1]), np.array([0.0, 0.0, 8.0]))
    seen = visible_samples(model, Camera(640, 480, 600.0, 600.0, 319.5, 239.5), far)
    assert sorted(set(seen.line.tolist())) == list(range(12))
    assert len(own_axes(model)) == 3


def test_a_model_without_size_says_so(tmp_path: Path) -> None:
    path = tmp_path / "dot.obj"
    path.write_text("v 1 2 3\n" * 3 + "f 1 2 3\n")
    with pytest.raises(GeometryError, match="has no size"):
        load_model(path)
