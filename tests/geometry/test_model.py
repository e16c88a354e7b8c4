"""Model files give the same wireframe whatever their kind, and bad ones say where they are wrong."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from geometry.camera import Camera
from geometry.errors import GeometryError
from geometry.mesh import MOST_TRIANGLES, READ_OFF
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


@pytest.mark.parametrize("kind", ["obj", "stl", "ply"])
def test_meshes_give_their_sharp_edges(tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"box.{kind}"
    trimesh.creation.box((0.1, 0.2, 0.3)).export(file)
    model = load_model(file)
    assert len(model.lines) == 12
    assert len(model.vertices) == 8
    assert not model.two_sided.any()


@pytest.mark.parametrize("flipped", [False, True])
def test_faces_that_are_there_twice_count_once(tmp_path: Path, flipped: bool) -> None:
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    again = box.faces[:, ::-1] if flipped else box.faces
    file = tmp_path / "box.ply"
    trimesh.Trimesh(box.vertices, np.vstack([box.faces, again]), process=False).export(file)
    assert len(load_model(file).lines) == 12


def test_a_round_mesh_has_only_outlines(tmp_path: Path) -> None:
    file = tmp_path / "ball.ply"
    trimesh.creation.icosphere(subdivisions=3, radius=0.1).export(file)
    model = load_model(file)
    assert model.smooth.all()
    assert len(model.lines) > 0


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


def test_a_model_without_faces_and_lines_is_refused(tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match="no faces, and no lines"):
        load_model(written(tmp_path, "V1\n2\n0 0 0\n1 0 0\n0\n0\n0\n"))


def test_other_bad_files(tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match="does not exist"):
        load_model(tmp_path / "none.cao")
    with pytest.raises(GeometryError, match="unknown kind"):
        load_model(tmp_path / "thing.doc")
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


def test_a_mesh_with_a_point_that_is_nowhere_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "part.obj"
    file.write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 3 4\n")
    with pytest.raises(GeometryError, match="not finite"):
        load_model(file)


def test_a_mesh_of_too_many_triangles_that_is_not_closed_says_what_to_do(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(6)
    trimesh.Trimesh(ball.vertices, ball.faces[1:], process=False).export(tmp_path / "fine.stl")
    with pytest.raises(GeometryError, match=r"81919 triangles, and at most 80000 are read.*coarser"):
        load_model(tmp_path / "fine.stl")


def test_a_closed_mesh_of_more_triangles_is_made_coarser(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(6, 0.1)
    ball.export(tmp_path / "fine.stl")
    model = load_model(tmp_path / "fine.stl")
    assert 1000 < len(model.triangles) < MOST_TRIANGLES
    assert not model.two_sided.any()
    np.testing.assert_allclose(np.linalg.norm(model.vertices, axis=1), 0.1, rtol=1e-4)
    middles = np.linalg.norm(model.vertices[model.triangles].mean(axis=1), axis=1)
    assert middles.min() > np.linalg.norm(ball.triangles_center, axis=1).min() - READ_OFF * model.diameter


@pytest.mark.parametrize(("scale", "said"), [(1e-6, "1.41e-06 m across"), (1e9, r"1.41e\+09 m across")])
def test_a_size_that_no_camera_sees_asks_for_the_unit(tmp_path: Path, scale: float, said: str) -> None:
    box = trimesh.creation.box((0.8 * scale, 0.6 * scale, 1.0 * scale))
    box.export(tmp_path / "box.stl")
    with pytest.raises(GeometryError, match=said + ".*unit 'm'"):
        load_model(tmp_path / "box.stl")


@pytest.mark.parametrize("kind", ["glb", "obj", "ply", "stl"])
def test_a_mesh_is_the_same_in_each_format(tmp_path: Path, kind: str) -> None:
    trimesh.creation.box((0.1, 0.08, 0.06)).export(tmp_path / f"box.{kind}")
    model = load_model(tmp_path / f"box.{kind}")
    assert len(model.lines) == 12
    assert not model.two_sided.any()
    assert np.ptp(model.vertices, axis=0) == pytest.approx([0.1, 0.08, 0.06])


@pytest.mark.parametrize("apart_mm", [2e-5, 2e-3])
def test_facets_that_hardly_miss_each_other_are_one_surface(tmp_path: Path, apart_mm: float) -> None:
    box = trimesh.creation.box((100.0, 80.0, 60.0))
    off = np.random.default_rng(0).uniform(-apart_mm, apart_mm, (36, 3))
    corners = box.vertices[box.faces].reshape(-1, 3) + off
    trimesh.Trimesh(corners + 500.0, np.arange(36).reshape(-1, 3), process=False).export(tmp_path / "box.stl")
    model = load_model(tmp_path / "box.stl", "mm")
    bent = [line for line, smooth in zip(model.lines, model.smooth, strict=True) if not smooth]
    assert len(bent) == 12
    assert not model.two_sided.any()


def test_a_stl_file_that_is_cut_short_says_so(tmp_path: Path) -> None:
    file = tmp_path / "box.stl"
    trimesh.creation.box((0.1, 0.08, 0.06)).export(file)
    whole = file.read_bytes()
    file.write_bytes(whole + b"made by a CAD program")
    assert len(load_model(file).lines) == 12
    file.write_bytes(whole[:-70])
    with pytest.raises(
        GeometryError, match="cut short, or is no STL file: of the 684 bytes that its 12 triangles"
    ):
        load_model(file)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.stl", "", "it is empty"),
        ("a.stl", "hello", "it is no STL file: it neither begins with `solid`"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a face names a point that the file does not have"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4: a face names point 0; the first is 1"),
        ("a.obj", "v 0 0 zero\nf 1 1 1\n", "its points and faces are not all numbers"),
        ("a.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1 0\nf 1 2 3\n", r"not finite, or over 1e\+10 from the origin"),
    ],
)
def test_what_is_wrong_with_a_mesh_is_said_in_plain_words(
    tmp_path: Path, name: str, text: str, said: str
) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(GeometryError, match=said):
        load_model(tmp_path / name)


def test_a_text_stl_may_have_a_name_in_any_letters(tmp_path: Path) -> None:
    text = trimesh.creation.box((0.1, 0.08, 0.06)).export(file_type="stl_ascii")
    (tmp_path / "box.stl").write_bytes(text.replace("solid", "solid Gehäuse", 1).encode("latin-1"))
    assert len(load_model(tmp_path / "box.stl").lines) == 12


def test_step_files_are_told_what_to_export(tmp_path: Path) -> None:
    (tmp_path / "part.step").write_text("ISO-10303-21;")
    with pytest.raises(GeometryError, match="exports STL"):
        load_model(tmp_path / "part.step")


def test_a_mesh_with_a_hole_or_wound_at_random_has_its_lines(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.08, 0.06))
    turned = box.faces.copy()
    turned[[3, 5]] = turned[[3, 5], ::-1]
    trimesh.Trimesh(box.vertices, turned, process=False).export(tmp_path / "turned.stl")
    again = load_model(tmp_path / "turned.stl")
    assert len(again.lines) == 12
    assert not again.two_sided.any()
    trimesh.Trimesh(box.vertices, box.faces[1:], process=False).export(tmp_path / "holed.stl")
    holed = load_model(tmp_path / "holed.stl")
    assert len(holed.lines) == 13
    assert holed.two_sided.all()


@pytest.mark.parametrize(
    ("flat", "said"), [((0.0, 0.0, 0.0), "has no size"), ((1.0, 0.0, 0.0), "has no faces")]
)
def test_a_mesh_without_area_has_no_faces(tmp_path: Path, flat: tuple[float, ...], said: str) -> None:
    box = trimesh.creation.box((0.1, 0.08, 0.06))
    trimesh.Trimesh(box.vertices * flat, box.faces, process=False).export(tmp_path / "flat.stl")
    with pytest.raises(GeometryError, match=said):
        load_model(tmp_path / "flat.stl")


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
