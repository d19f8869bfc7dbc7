"""The STL reader: both encodings agree, counts are checked, bad values are named."""

from __future__ import annotations

import csv
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from assetkit.readers.stl import read_stl, weld
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import InvalidInput
from schemas.model import Model

ASSETS = Path(__file__).parents[3].parent / "shared" / "data" / "assets"
TETRA = np.array(
    [
        [[0, 0, 0], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
        [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    ],
    dtype=float,
)


def binary(corners: np.ndarray, header: bytes = b"units: mm", count: int | None = None) -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in corners)
    return header.ljust(80) + struct.pack("<I", len(corners) if count is None else count) + body


def ascii_(corners: np.ndarray, name: str = "part in mm") -> str:
    rows = [f"solid {name}"]
    for t in corners:
        rows += ["facet normal 0 0 0", " outer loop", *(f"  vertex {x!r} {y!r} {z!r}" for x, y, z in t.tolist())]
        rows += [" endloop", "endfacet"]
    return "\n".join([*rows, f"endsolid {name}", ""])


def read(folder: Path, content: bytes | str) -> Model:
    path = folder / "part.stl"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    model = read_stl(SourceFile(path, folder)).value
    assert model is not None
    return model


def rejected(folder: Path, content: bytes | str) -> tuple[str, int | None]:
    with pytest.raises(InvalidInput) as caught:
        read(folder, content)
    return caught.value.diagnostic.code, caught.value.diagnostic.where.line


@pytest.mark.parametrize(
    "content",
    [
        binary(TETRA),
        binary(TETRA, header=b"solid that is binary"),
        binary(TETRA) + b"trailing bytes",
        ascii_(TETRA),
        ascii_(TETRA).replace("\n", "\r\n"),
        ascii_(TETRA).upper().replace("E+", "e+"),
    ],
)
def test_both_encodings_give_the_same_welded_tetrahedron(tmp_path: Path, content: bytes | str) -> None:
    mesh = read(tmp_path, content).meshes[0]
    assert (mesh.points.shape, mesh.triangles.shape) == ((4, 3), (4, 3))
    np.testing.assert_array_equal(mesh.points[mesh.triangles], TETRA)


def test_headers_and_names_become_hints_and_solids_become_meshes(tmp_path: Path) -> None:
    assert read(tmp_path, binary(TETRA)).hints == ("units: mm",)
    model = read(tmp_path, ascii_(TETRA, "lid") + ascii_(TETRA[:0], "nothing") + ascii_(TETRA + 5, "base"))
    assert [m.name for m in model.meshes] == ["lid", "base"]
    assert model.hints == ("lid", "nothing", "base")
    assert model.meters_per_unit.confidence == 0.0


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (binary(TETRA, count=2_000_000_000), ("asset/truncated", None)),
        (binary(TETRA)[:-20], ("asset/truncated", None)),
        (binary(TETRA)[:60] + b"\x00", ("asset/truncated", None)),
        (binary(TETRA[:0]), ("asset/empty-geometry", None)),
        ("solid a\nendsolid a\n", ("asset/empty-geometry", None)),
        (ascii_(TETRA)[:200], ("asset/truncated", ascii_(TETRA)[:200].count("\n") + 1)),
        (binary(np.where(TETRA == 1, np.nan, TETRA)), ("asset/nonfinite-vertices", None)),
        (ascii_(TETRA).replace("1.0", "inf", 1), ("asset/nonfinite-vertices", 5)),
        (ascii_(TETRA).replace("1.0", "one", 1), ("asset/parse-error", 5)),
        (ascii_(TETRA).replace("  vertex 0.0 1.0 0.0\n", "", 1), ("asset/parse-error", 7)),
        ("no geometry here, just text", ("asset/parse-error", 1)),
        ("<html><body>404</body></html>", ("asset/wrong-content", None)),
        (b"glTF\x02\x00\x00\x00" + bytes(200), ("asset/wrong-content", None)),
        ("version https://git-lfs.github.com/spec/v1\n", ("asset/lfs-pointer", None)),
    ],
)
def test_bad_files_are_rejected(tmp_path: Path, content: bytes | str, expected: tuple[str, int | None]) -> None:
    assert rejected(tmp_path, content) == expected


def test_a_count_that_was_never_filled_in_is_corrected_and_said(tmp_path: Path) -> None:
    path = tmp_path / "part.stl"
    path.write_bytes(binary(TETRA, count=0))
    outcome = read_stl(SourceFile(path, tmp_path))
    assert outcome.value is not None
    assert outcome.value.triangle_count == 4
    assert [r.name for r in outcome.repairs] == ["triangle_count"]


@given(arrays(np.float64, st.tuples(st.integers(1, 30), st.just(3)), elements=st.sampled_from([-0.0, 0.0, 1.0, 2.0])))
def test_weld_loses_no_corner_and_keeps_no_duplicate(points: np.ndarray) -> None:
    distinct, index = weld(points)
    np.testing.assert_array_equal(distinct[index], points)
    assert len(np.unique(distinct + 0.0, axis=0)) == len(distinct)
    assert index[0] == 0
    assert (np.diff(np.unique(index, return_index=True)[1]) > 0).all()


@settings(max_examples=200, deadline=None)
@given(st.booleans(), st.integers(0, 500), st.integers(0, 60), st.binary(max_size=5))
def test_mutated_bytes_never_crash(
    tmp_path_factory: pytest.TempPathFactory, text: bool, at: int, cut: int, extra: bytes
) -> None:
    data = ascii_(TETRA).encode() if text else binary(TETRA)
    try:
        model = read(tmp_path_factory.mktemp("fuzz"), data[:at] + extra + data[at + cut :])
    except InvalidInput:
        return
    assert all(np.isfinite(m.points).all() for m in model.meshes)


@pytest.mark.shared
@pytest.mark.skipif(not ASSETS.is_dir(), reason="shared data folder is absent")
def test_real_files_agree_with_the_manifest_and_trimesh() -> None:
    with (ASSETS / "manifest.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["format"] == "stl"]
    for row in rows:
        source = SourceFile(ASSETS / row["path"], ASSETS)
        if row["reason"] in {"empty_geometry", "nonfinite_vertices", "truncated", "wrong_content"}:
            with pytest.raises(InvalidInput) as caught:
                read_stl(source)
            assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-"), row["id"]
            continue
        model = read_stl(source).value
        assert model is not None
        reference = trimesh.load_mesh(source.path, process=False)
        assert model.triangle_count == len(reference.faces), row["id"]
        points = np.concatenate([m.points for m in model.meshes])
        np.testing.assert_allclose(np.ptp(points, axis=0), reference.extents, rtol=1e-6, err_msg=row["id"])
