"""glTF files give the part's shape, and what would come out as another one is refused in plain words."""

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from geometry.errors import GeometryError
from geometry.model import files_of_model, load_model

BYTE, SHORT, UNSIGNED, FLOAT = 5120, 5122, 5125, 5126
SIZE = (0.1, 0.08, 0.06)


def document(points: np.ndarray, kind: int, **accessor: Any) -> dict[str, Any]:
    """A box's glTF: its points (8, 3), of this kind of number; `accessor` adds to what is said of them."""
    faces = trimesh.creation.box(SIZE).faces.astype("<u4")
    row = np.zeros((len(points), 4), dtype=points.dtype)
    row[:, :3] = points
    content = row.tobytes() + faces.tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(content), "uri": uri}],
        "bufferViews": [
            {"buffer": 0, "byteLength": row.nbytes, "byteStride": row.strides[0]},
            {"buffer": 0, "byteOffset": row.nbytes, "byteLength": faces.nbytes},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": kind, "count": len(points), "type": "VEC3", **accessor},
            {"bufferView": 1, "componentType": UNSIGNED, "count": faces.size, "type": "SCALAR"},
        ],
    }


def box(**accessor: Any) -> dict[str, Any]:
    """The document of a box of SIZE, metres."""
    return document(trimesh.creation.box(SIZE).vertices.astype("<f4"), FLOAT, **accessor)


def written(file: Path, said: dict[str, Any]) -> Path:
    """The file, text or binary as its name says."""
    plain = json.dumps(said).encode()
    plain += b" " * (-len(plain) % 4)
    head = b"glTF" + struct.pack("<IIII", 2, 20 + len(plain), len(plain), 0x4E4F534A)
    file.write_bytes(head + plain if file.suffix == ".glb" else plain)
    return file


def must_be_the_box(file: Path) -> None:
    model = load_model(file)
    assert len(model.lines) == 12
    assert np.ptp(model.vertices, axis=0) == pytest.approx(SIZE, rel=1e-3)


def test_a_gltf_file_whose_numbers_were_left_behind_is_told_so(tmp_path: Path) -> None:
    trimesh.creation.box(SIZE).export(tmp_path / "box.gltf")
    (tmp_path / "gltf_buffer_0.bin").unlink()
    with pytest.raises(GeometryError, match=r"box.gltf needs the file gltf_buffer_0.bin, which is not"):
        load_model(tmp_path / "box.gltf")


@pytest.mark.parametrize("name", ["my%20part%C3%A4.bin", "my partä.bin"])
def test_a_file_beside_it_may_have_any_name(tmp_path: Path, name: str) -> None:
    said = box()
    content = base64.b64decode(said["buffers"][0]["uri"].split(",")[1])
    (tmp_path / "my partä.bin").write_bytes(content)
    said["buffers"][0]["uri"] = name
    must_be_the_box(written(tmp_path / "box.gltf", said))


def test_a_gltf_file_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    file = written(tmp_path / "box.GLTF", box())
    file.write_text(file.read_text(), encoding="utf-8-sig")
    must_be_the_box(file)


@pytest.mark.parametrize("kind", ["glb", "gltf"])
@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
def test_a_compressed_gltf_file_is_told_to_be_so(tmp_path: Path, kind: str, name: str) -> None:
    """It would else have all of its points in one place."""
    file = written(tmp_path / f"box.{kind}", {"asset": {"version": "2.0"}, "extensionsRequired": [name]})
    with pytest.raises(GeometryError, match=rf"meshes are compressed \({name}\). Export it without"):
        load_model(file)


@pytest.mark.parametrize("kind", ["glb", "gltf"])
@pytest.mark.parametrize("name", ["CESIUM_RTC", "EXT_mesh_gpu_instancing", "VENDOR_anything"])
def test_a_required_extension_that_may_move_points_is_named(tmp_path: Path, kind: str, name: str) -> None:
    file = written(
        tmp_path / f"box.{kind}", {**box(), "extensionsUsed": [name], "extensionsRequired": [name]}
    )
    with pytest.raises(
        GeometryError, match=rf"box.{kind} .*requires the extension {name}, which is not read"
    ):
        load_model(file)


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_an_extension_of_how_a_part_looks_does_no_harm(tmp_path: Path, kind: str) -> None:
    names = ["KHR_materials_unlit", "KHR_texture_transform", "KHR_lights_punctual", "EXT_texture_webp"]
    must_be_the_box(
        written(tmp_path / f"box.{kind}", {**box(), "extensionsUsed": names, "extensionsRequired": names})
    )


def test_compression_that_is_not_required_has_plain_points_beside_it(tmp_path: Path) -> None:
    used = {"extensionsUsed": ["KHR_draco_mesh_compression"]}
    must_be_the_box(written(tmp_path / "box.gltf", {**box(), **used}))


@pytest.mark.parametrize("kind", ["glb", "gltf"])
@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("base", [True, False])
def test_sparse_points_or_corners_are_refused(tmp_path: Path, kind: str, which: int, base: bool) -> None:
    """They were left out: the part had the shape of what they are to replace."""
    said = box()
    said["accessors"][which]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": 1, "componentType": UNSIGNED},
        "values": {"bufferView": 0},
    }
    if not base:
        del said["accessors"][which]["bufferView"]
    file = written(tmp_path / f"box.{kind}", said)
    with pytest.raises(GeometryError, match=rf"box.{kind} .*sparse accessors. Export it without them"):
        load_model(file)


@pytest.mark.parametrize("required", [True, False])
def test_points_that_are_fractions_as_integers_are_refused(tmp_path: Path, required: bool) -> None:
    """They were taken for the integers: the part was 32767 times as large."""
    points = np.round(trimesh.creation.box(SIZE).vertices / 0.05 * 32767).astype("<i2")
    said = document(points, SHORT, normalized=True)
    if required:
        said["extensionsUsed"] = said["extensionsRequired"] = ["KHR_mesh_quantization"]
    with pytest.raises(GeometryError, match=r"its points are normalized integers. Export it without"):
        load_model(written(tmp_path / "box.gltf", said))


def test_points_that_are_plain_integers_are_read(tmp_path: Path) -> None:
    said = document(np.round(trimesh.creation.box(SIZE).vertices / 0.001).astype("<i1"), BYTE)
    said["nodes"][0]["scale"] = [0.001] * 3
    said["extensionsUsed"] = said["extensionsRequired"] = ["KHR_mesh_quantization"]
    must_be_the_box(written(tmp_path / "box.gltf", said))


@pytest.mark.parametrize(
    ("changed", "refusal"),
    [
        ({"extensionsUsed": ["EXT_mesh_gpu_instancing"]}, "its bodies are instances"),
        ({"nodes": [{"mesh": 0, "weights": [0.0, 0.5]}]}, "deformed .morph targets.. Export it without"),
        ({"nodes": [{"mesh": 0, "skin": 0}]}, "deformed .skins.. Export it without"),
        ({"nodes": [{"mesh": 0, "camera": 0}]}, "its bodies hang on a camera. Export it without"),
        (
            {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 6}]}]},
            "of triangle fans. Export it with plain triangles",
        ),
        ({"asset": {"version": "1.0"}, "meshes": {}}, "it is of glTF 1. Export glTF 2"),
    ],
)
def test_what_the_reader_leaves_out_is_refused(tmp_path: Path, changed: dict[str, Any], refusal: str) -> None:
    with pytest.raises(GeometryError, match=refusal):
        load_model(written(tmp_path / "box.gltf", {**box(), **changed}))


def test_a_gltf_file_that_is_cut_short_says_so(tmp_path: Path) -> None:
    file = written(tmp_path / "box.gltf", box())
    file.write_bytes(file.read_bytes()[:200])
    with pytest.raises(GeometryError, match="it is no glTF file, or was cut short"):
        load_model(file)


def test_its_files_are_those_beside_it_or_below(tmp_path: Path) -> None:
    (tmp_path / "a b.bin").touch()
    file = tmp_path / "part.gltf"
    uris = ["a%20b.bin", "below/c.bin", "data:application/octet-stream;base64,AAAA"]
    file.write_text(json.dumps({"buffers": [*({"uri": uri} for uri in uris), {}]}))
    assert files_of_model(file) == [file, tmp_path / "a b.bin", tmp_path / "below" / "c.bin"]
    file.write_text(json.dumps({"buffers": [{"uri": "../c.bin"}]}))
    with pytest.raises(GeometryError, match=r"reads .*\.\./c\.bin, which is not beside it or below"):
        files_of_model(file)
    file.write_text("[]")
    assert files_of_model(file) == [file]


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (["buffers", 0], "x"),
        (["nodes"], 3),
        (["nodes", 0, "matrix"], [1.0] * 17),
        (["accessors", 0, "count"], 10**300),
        (["meshes", 0, "primitives", 0, "indices"], 77),
        (["bufferViews", 1, "byteLength"], "12"),
        (["buffers", 0, "uri"], "no\0name"),
        (["buffers", 0, "uri"], "."),
    ],
)
@pytest.mark.parametrize("name", ["part.gltf", "part.glb"])
def test_wrong_types_and_numbers_are_told_without_words_of_python(
    tmp_path: Path, name: str, place: list[Any], value: object
) -> None:
    said = box()
    inner: Any = said
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    file = written(tmp_path / name, said)
    with pytest.raises(GeometryError, match=rf"{name} cannot be read as a mesh: it is damaged, or says what"):
        load_model(file)
    files_of_model(file)
