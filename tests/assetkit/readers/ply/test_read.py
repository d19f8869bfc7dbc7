"""The PLY reader: the three encodings agree, lists of any length, attributes follow corners, lies are found."""

from __future__ import annotations

import csv
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from assetkit.readers.ply.read import read_ply
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import InvalidInput
from schemas.model import Mesh, Model
from schemas.outcome import Outcome

ASSETS = Path(__file__).parents[4].parent / "shared" / "data" / "assets"
# A pyramid of height 1 on the unit square: one quad and four triangles.
POINTS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.5, 0.5, 1.0)]
FACES = [(3, 2, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]


def header(encoding: str, points: int = 5, faces: int = 5) -> str:
    return (
        f"ply\nformat {encoding} 1.0\ncomment units: mm\nobj_info scanned\n"
        f"element vertex {points}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )


def ascii_pyramid() -> str:
    rows = [" ".join(map(str, p)) for p in POINTS] + [f"{len(f)} " + " ".join(map(str, f)) for f in FACES]
    return header("ascii") + "\n".join(rows) + "\n"


def binary_pyramid(order: str, faces: list[tuple[int, ...]] = FACES) -> bytes:
    name = "binary_little_endian" if order == "<" else "binary_big_endian"
    body = b"".join(struct.pack(order + "3f", *p) for p in POINTS)
    body += b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in faces)
    return header(name, faces=len(faces)).encode() + body


def read(folder: Path, content: bytes | str) -> Outcome[Model]:
    path = folder / "part.ply"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_ply(SourceFile(path, folder))


def mesh(folder: Path, content: bytes | str) -> Mesh:
    model = read(folder, content).value
    assert model is not None
    assert len(model.meshes) == 1
    return model.meshes[0]


def volume(m: Mesh) -> float:
    t = m.points[m.triangles]
    return float(np.einsum("ij,ij->i", t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6)


@pytest.mark.parametrize(
    "content",
    [
        ascii_pyramid(),
        ascii_pyramid().replace("\n", "\r\n"),
        ascii_pyramid().replace("\n", "\r"),
        binary_pyramid("<"),
        binary_pyramid(">"),
        binary_pyramid("<").replace(b"\n", b"\r\n", 11),
        ascii_pyramid().replace("vertex_indices", "vertex_index"),
    ],
)
def test_all_encodings_give_the_same_pyramid(tmp_path: Path, content: bytes | str) -> None:
    m = mesh(tmp_path, content)
    assert len(m.triangles) == 6
    assert volume(m) == pytest.approx(1 / 3)
    np.testing.assert_array_equal(m.points, POINTS)


def test_comments_and_obj_info_become_hints(tmp_path: Path) -> None:
    model = read(tmp_path, ascii_pyramid()).value
    assert model is not None
    assert model.hints == ("comment units: mm", "obj_info scanned")
    assert model.up_axis.source == "default"


def test_a_binary_file_of_triangles_takes_the_fast_way_to_the_same_mesh(tmp_path: Path) -> None:
    triangles = [(3, 2, 1), (3, 1, 0), *FACES[1:]]
    assert volume(mesh(tmp_path, binary_pyramid("<", triangles))) == pytest.approx(1 / 3)


def test_vertex_attributes_follow_their_corners(tmp_path: Path) -> None:
    text = """ply
format ascii 1.0
element vertex 3
property double x
property double y
property double z
property float nx
property float ny
property float nz
property uchar red
property uchar green
property uchar blue
property uchar alpha
property float u
property float v
element face 1
property list uchar uint vertex_indices
end_header
0 0 0 0 0 2 255 0 0 255 0 0
1 0 0 0 0 2 0 128 0 255 1 0
0 1 0 0 0 2 0 0 0 0 0 1
3 0 1 2
"""
    m = mesh(tmp_path, text)
    assert m.normals is not None
    assert m.normals[0].tolist() == [[0, 0, 1]] * 3
    assert m.uvs[0][0].tolist() == [[0, 0], [1, 0], [0, 1]]
    assert m.colors is not None
    np.testing.assert_allclose(m.colors[0, 1], [0, ((128 / 255 + 0.055) / 1.055) ** 2.4, 0, 1], rtol=1e-5)
    assert m.colors[0, 2, 3] == 0


def test_face_colours_texture_lists_and_texture_files(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2), (200, 0, 0)).save(tmp_path / "a b.png")
    text = ascii_pyramid().replace("comment units: mm", "comment TextureFile a b.png\ncomment TextureFile absent.png")
    text = text.replace(
        "vertex_indices\n",
        "vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nproperty float red\n"
        "property float green\nproperty float blue\n",
    )
    body = "".join(
        f"{len(f)} {' '.join(map(str, f))} {2 * len(f)} {' '.join(['0.25', '0.75'] * len(f))} {int(i == 0)} 1 0 0\n"
        for i, f in enumerate(FACES)
    )
    outcome = read(tmp_path, text[: text.index("4 3 2 1 0")] + body)
    model = outcome.value
    assert model is not None
    assert [(m.material, len(m.triangles)) for m in model.meshes] == [(0, 4), (1, 2)]
    assert all((m.uvs[0] == [0.25, 0.75]).all() for m in model.meshes)
    assert all(m.colors is not None and (m.colors == [1, 0, 0, 1]).all() for m in model.meshes)
    assert [r.name for r in outcome.repairs] == ["missing_texture"]
    assert [m.base_color_texture is not None for m in model.materials] == [True, False]


def test_triangle_strips_are_unrolled_with_one_winding(tmp_path: Path) -> None:
    text = ascii_pyramid().replace("element face 5", "element tristrips 1")
    # The base as one strip of four, three of the sides as strips of three.
    strip = "17 3 2 0 1 -1 0 1 4 -1 1 2 4 -1 2 3 4 -1"
    m = mesh(tmp_path, text[: text.index("4 3 2 1 0")] + strip)
    assert len(m.triangles) == 5
    whole = mesh(tmp_path, text[: text.index("4 3 2 1 0")] + "20 3 2 0 1 -1 0 1 4 -1 1 2 4 -1 2 3 4 -1 3 0 4")
    assert volume(whole) == pytest.approx(1 / 3)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (header("ascii", points=2_000_000_000) + "0 0 0\n", ("asset/truncated", None)),
        (header("binary_little_endian", points=2_000_000_000).encode() + bytes(64), ("asset/truncated", None)),
        (binary_pyramid("<")[:-3], ("asset/truncated", None)),
        (ascii_pyramid()[:-4], ("asset/truncated", None)),
        (ascii_pyramid()[:80], ("asset/truncated", None)),
        (header("ascii", 0, 0), ("asset/empty-geometry", None)),
        (header("ascii", 5, 0) + "0 0 0\n" * 5, ("asset/no-faces", None)),
        (ascii_pyramid().replace("element face 5", "element edge 5"), ("asset/no-faces", None)),
        (ascii_pyramid().replace("0.5 0.5 1.0", "0.5 nan 1.0"), ("asset/nonfinite-vertices", None)),
        (ascii_pyramid().replace("0.5 0.5 1.0", "0.5 half 1.0"), ("asset/parse-error", 16)),
        (ascii_pyramid().replace("3 0 1 4", "3 0 1 99"), ("asset/index-out-of-range", None)),
        (ascii_pyramid().replace("3 0 1 4", "x 0 1 4"), ("asset/parse-error", 18)),
        (ascii_pyramid().replace("float y", "quaternion y"), ("asset/parse-error", 7)),
        (ascii_pyramid().replace("float y", "float x"), ("asset/parse-error", 7)),
        (ascii_pyramid().replace("float z", "float w"), ("asset/schema-error", None)),
        (ascii_pyramid().replace("format ascii 1.0\n", ""), ("asset/parse-error", 1)),
        ("solid x\nendsolid", ("asset/parse-error", 1)),
        ("<!doctype html>", ("asset/wrong-content", None)),
        ("version https://git-lfs.github.com/spec/v1\n", ("asset/lfs-pointer", None)),
        (ascii_pyramid().replace("units: mm", "TextureFile ../../x.png"), ("asset/path-escape", None)),
    ],
)
def test_bad_files_are_rejected(tmp_path: Path, content: bytes | str, expected: tuple[str, int | None]) -> None:
    with pytest.raises(InvalidInput) as caught:
        read(tmp_path, content)
    assert (caught.value.diagnostic.code, caught.value.diagnostic.where.line) == expected


def test_faces_with_two_corners_are_dropped_and_said(tmp_path: Path) -> None:
    outcome = read(tmp_path, ascii_pyramid().replace("3 0 1 4", "2 0 1"))
    assert outcome.value is not None
    assert outcome.value.triangle_count == 5
    assert [r.name for r in outcome.repairs] == ["empty_face_record"]


@settings(max_examples=300, deadline=None)
@given(st.sampled_from("<>a"), st.integers(0, 400), st.integers(0, 60), st.binary(max_size=5))
def test_mutated_bytes_never_crash(
    tmp_path_factory: pytest.TempPathFactory, kind: str, at: int, cut: int, extra: bytes
) -> None:
    data = ascii_pyramid().encode() if kind == "a" else binary_pyramid(kind)
    try:
        model = read(tmp_path_factory.mktemp("fuzz"), data[:at] + extra + data[at + cut :]).value
    except InvalidInput:
        return
    assert model is not None
    assert all(np.isfinite(m.points).all() and m.triangles.max() < len(m.points) for m in model.meshes)


@pytest.mark.shared
@pytest.mark.skipif(not ASSETS.is_dir(), reason="shared data folder is absent")
def test_real_files_agree_with_the_manifest_and_trimesh() -> None:
    with (ASSETS / "manifest.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["format"] == "ply"]
    for row in rows:
        path = ASSETS / row["path"]
        if row["reason"] in {"empty_geometry", "no_faces", "truncated"}:
            with pytest.raises(InvalidInput) as caught:
                read_ply(SourceFile(path, path.parent))
            assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-"), row["id"]
            continue
        model = read_ply(SourceFile(path, path.parent)).value
        assert model is not None
        reference = trimesh.load_mesh(path, process=False)
        assert model.triangle_count == len(reference.faces), row["id"]
        points = np.concatenate([m.points for m in model.meshes])
        np.testing.assert_allclose(np.ptp(points, axis=0), reference.extents, rtol=1e-6, err_msg=row["id"])


def test_a_comment_that_goes_on_without_its_keyword_is_read_as_other_readers_do(tmp_path: Path) -> None:
    data = trimesh.creation.box((0.1, 0.08, 0.06)).export(file_type="ply", encoding="ascii")
    assert isinstance(data, bytes)
    plain = data.replace(b"comment https", b"comment scanned by\nsomebody https", 1)
    assert plain != data
    broken = read(tmp_path, plain).value
    whole = read(tmp_path, data).value
    assert broken is not None
    assert whole is not None
    np.testing.assert_array_equal(broken.meshes[0].points, whole.meshes[0].points)
    with pytest.raises(InvalidInput):
        read(tmp_path, data.replace(b"element vertex", b"elements vertex", 1))
