"""Meshes give the same wireframe whatever their format, and bad ones are refused in plain words."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from geometry.errors import GeometryError
from geometry.mesh import MOST_TRIANGLES, READ_OFF
from geometry.model import load_model


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


def test_a_mesh_with_a_point_that_is_nowhere_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "part.obj"
    file.write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 3 4\n")
    with pytest.raises(GeometryError, match="not finite"):
        load_model(file)


def test_a_mesh_of_too_many_triangles_that_is_not_closed_says_what_to_do(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(6)
    trimesh.Trimesh(ball.vertices, ball.faces[1:], process=False).export(tmp_path / "fine.stl")
    with pytest.raises(GeometryError, match=r"81919 .* as it is not closed at most 80000 .* Close its holes"):
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


def test_bodies_that_touch_are_made_coarser(tmp_path: Path) -> None:
    """Of the facets between them one of two was left, so that they were refused as not closed."""
    below, above = trimesh.creation.box((0.1, 0.1, 0.1)), trimesh.creation.box((0.1, 0.1, 0.1))
    above.apply_translation([0.0, 0.0, 0.1])
    coarse = below + above
    fine = coarse.subdivide()
    for _ in range(5):
        fine = fine.subdivide()
    coarse.export(tmp_path / "coarse.stl")
    fine.export(tmp_path / "fine.stl")
    model = load_model(tmp_path / "fine.stl")
    assert len(fine.faces) > MOST_TRIANGLES > len(model.triangles)
    assert len(model.lines) == len(load_model(tmp_path / "coarse.stl").lines) == 20
    assert np.ptp(model.vertices, axis=0) == pytest.approx([0.1, 0.1, 0.2])


def test_a_mesh_that_is_too_finely_bent_says_how_many_are_left(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(6, 0.1)
    off = 0.002 * np.random.default_rng(1).uniform(-1.0, 1.0, (len(ball.vertices), 1))
    trimesh.Trimesh(ball.vertices * (1.0 + off), ball.faces, process=False).export(tmp_path / "rough.stl")
    with pytest.raises(GeometryError, match=r"of its 81920 triangles 8\d{4} are left .* by 0.01 % of"):
        load_model(tmp_path / "rough.stl")


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


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.stl", "", "it is empty"),
        ("a.stl", "hello", "it is no STL file: it neither begins with `solid`"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "names a point that the file does not have"),
        (
            "a.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\n",
            "names a point that the file does not have",
        ),
        (
            "a.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 9\n",
            "names a point that the file does not have",
        ),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 x\n", "its points and faces are not all numbers"),
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


def test_an_obj_file_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    """Its first point was left out."""
    text = trimesh.creation.box((0.1, 0.08, 0.06)).export(file_type="obj", header=None)
    assert text.startswith("v ")
    (tmp_path / "box.obj").write_text(text, encoding="utf-8-sig")
    assert len(load_model(tmp_path / "box.obj").lines) == 12


def test_facets_that_are_cut_finer_than_their_neighbours_leave_the_surface_closed(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.08, 0.06))
    box.subdivide(np.arange(0, 12, 3)).export(tmp_path / "box.stl")
    model = load_model(tmp_path / "box.stl")
    assert not model.two_sided.any()
    assert np.linalg.norm(np.diff(model.vertices[model.lines], axis=1), axis=2).sum() == pytest.approx(0.96)


@pytest.mark.parametrize("kind", ["obj", "ply"])
def test_a_corner_on_a_straight_side_is_of_both_faces_beside_it(tmp_path: Path, kind: str) -> None:
    """A fan of such a face has a facet without area, as have those of programs that close meshes."""
    around = np.array([(0.0, 0.0), (0.04, 0.0), (0.08, 0.0), (0.08, 0.06), (0.0, 0.06)])
    points = np.vstack([np.column_stack([around, np.full(5, height)]) for height in (0.0, 0.01)])
    faces = [[4, 3, 2, 1, 0], [5, 6, 7, 8, 9], *([i, (i + 1) % 5, (i + 1) % 5 + 5, i + 5] for i in range(5))]
    file = tmp_path / f"plate.{kind}"
    if kind == "obj":
        rows = [f"v {x} {y} {z}" for x, y, z in points]
        rows += ["f " + " ".join(str(k + 1) for k in face) for face in faces]
    else:
        rows = ["ply", "format ascii 1.0", "element vertex 10", *(f"property float {axis}" for axis in "xyz")]
        rows += ["element face 7", "property list uchar int vertex_indices", "end_header"]
        rows += [f"{x} {y} {z}" for x, y, z in points]
        rows += [" ".join(map(str, [len(face), *face])) for face in faces]
    file.write_text("\n".join(rows) + "\n")
    model = load_model(file)
    assert not model.two_sided.any()
    assert np.linalg.norm(np.diff(model.vertices[model.lines], axis=1), axis=2).sum() == pytest.approx(0.6)


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


@pytest.mark.parametrize(("scale", "said"), [(1e-6, "1.41e-06 m across"), (1e9, r"1.41e\+09 m across")])
def test_a_size_that_no_camera_sees_asks_for_the_unit(tmp_path: Path, scale: float, said: str) -> None:
    box = trimesh.creation.box((0.8 * scale, 0.6 * scale, 1.0 * scale))
    box.export(tmp_path / "box.stl")
    with pytest.raises(GeometryError, match=said + ".*unit 'm'"):
        load_model(tmp_path / "box.stl")


def test_a_small_part_far_from_its_origin_is_not_taken_for_another_one(tmp_path: Path) -> None:
    box = trimesh.creation.box((100.0, 80.0, 60.0))
    box.apply_translation([1e7, 0.0, 0.0])
    box.export(tmp_path / "far.stl")
    with pytest.raises(GeometryError, match=r"far from its origin .* to 1 only\. Move"):
        load_model(tmp_path / "far.stl", "mm")
