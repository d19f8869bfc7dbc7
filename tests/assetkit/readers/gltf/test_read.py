"""The glTF reader as a whole: evidence, damage of every kind, real files against an independent reader."""

import base64
import copy
import csv
import json
import struct
import tempfile
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from assetkit.readers.gltf.read import read_gltf
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import InvalidInput, Severity
from schemas.model import Mesh
from schemas.outcome import Outcome
from tests.conftest import SHARED
from tests.support.gltf_files import POINTS, GltfFile, read, tetrahedron

ASSETS = SHARED / "assets"
shared = pytest.mark.shared


# The rest of the model.


def test_evidence_hints_and_metadata(tmp_path):
    file = tetrahedron()
    file.doc["asset"].update(
        generator="Blender", copyright="2024 A", extras={"author": "Ann", "license": "CC0", "views": 3}
    )
    file.doc["nodes"][0]["name"] = "mug_mm"
    file.doc["animations"] = [{"channels": [], "samplers": []}]
    outcome = read(tmp_path, file.glb())
    value = outcome.value
    assert value is not None
    assert (value.meters_per_unit.value, value.meters_per_unit.source) == (1.0, "declared")
    assert (value.up_axis.value, value.up_axis.source) == ("y", "declared")
    assert {"Blender", "2024 A", "mug_mm"} <= set(value.hints)
    assert value.metadata == {"author": "Ann", "copyright": "2024 A", "generator": "Blender", "license": "CC0"}
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/animation-dropped", Severity.INFO)]


# Nothing else escapes.


def rich_file() -> GltfFile:
    file = tetrahedron()
    uv = file.accessor(POINTS[:, :2].copy(), sparse={"count": 0, "indices": {"bufferView": 0, "componentType": 5121},
                                                     "values": {"bufferView": 0}})  # fmt: skip
    primitive = file.doc["meshes"][0]["primitives"][0]
    primitive["attributes"]["TEXCOORD_0"] = uv
    primitive["material"] = 0
    file.doc["images"] = [{"uri": "data:image/png;base64," + base64.b64encode(b"\x89PNG").decode()}]
    file.doc["samplers"] = [{"wrapS": 33071}]
    file.doc["textures"] = [{"source": 0, "sampler": 0}]
    texture = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 1}}}
    file.doc["materials"] = [
        {
            "name": "m",
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "baseColorTexture": texture, "metallicFactor": 0},
            "normalTexture": {"index": 0, "scale": 1},
            "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_clearcoat": {"clearcoatFactor": 1}},
        }
    ]
    file.doc["nodes"] = [{"children": [1], "translation": [0, 0, 0]}, {"mesh": 0, "name": "n", "scale": [1, 1, 1]}]
    return file


def leaves(value: object, path: tuple = ()) -> list[tuple]:
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(leaf for key, child in pairs for leaf in leaves(child, (*path, key)))]


def test_any_wrong_value_anywhere_is_an_outcome_or_a_finding(tmp_path):
    original = rich_file()
    assert read(tmp_path, original.glb()).value is not None
    places = leaves(original.doc)[1:]
    assert len(places) > 100
    for path in places:
        for value in (None, "x", [], {}, [None], -1, 0.5, 1e300, 10**30, True, 2**31):
            file = GltfFile()
            file.doc, file.blob = copy.deepcopy(original.doc), original.blob
            target = file.doc
            for key in path[:-1]:
                target = target[key]
            target[path[-1]] = value
            try:
                assert isinstance(read(tmp_path, file.gltf(), "part.gltf"), Outcome)
            except InvalidInput:
                continue


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=5), st.integers(0, 4000))
def test_any_damaged_glb_is_an_outcome_or_a_finding(edits, length):
    data = bytearray(rich_file().glb())
    for position, value in edits:
        data[position % len(data)] = value
    with tempfile.TemporaryDirectory() as folder:
        try:
            assert isinstance(read(Path(folder), bytes(data[:length])), Outcome)
        except InvalidInput as error:
            json.dumps(error.diagnostic.model_dump())


# Real files.


def rows() -> list[dict[str, str]]:
    if not ASSETS.is_dir():
        return []
    with (ASSETS / "manifest.csv").open(newline="") as file:
        return [row for row in csv.DictReader(file) if row["path"].endswith((".glb", ".gltf"))]


def asset_root(path: str) -> Path:
    parts = Path(path).parts
    return ASSETS.joinpath(*parts[: 3 if parts[0] == "malformed" else 2])


def _is_sparse(document: dict) -> bool:
    return any("sparse" in accessor for accessor in document["accessors"])


def _document(path: Path) -> dict:
    data = path.read_bytes()
    return json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]] if data.startswith(b"glTF") else data)


@shared
@pytest.mark.parametrize("row", [r for r in rows() if r["outcome"] == "reject"], ids=lambda r: r["id"])
def test_bad_files_are_refused_for_their_reason(row):
    with pytest.raises(InvalidInput) as caught:
        read_gltf(SourceFile(ASSETS / row["path"], asset_root(row["path"])))
    assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-")


@shared
@pytest.mark.parametrize("row", [r for r in rows() if r["outcome"] != "reject"], ids=lambda r: r["id"])
def test_good_files_are_read_at_their_size(row):
    path = ASSETS / row["path"]
    outcome = read_gltf(SourceFile(path, asset_root(row["path"])))
    assert not outcome.failed
    assert outcome.value is not None
    assert bool(outcome.repairs) == (row["outcome"] == "repair")
    points = np.concatenate([m.points for m in outcome.value.meshes])
    if row["measured_extent_native"] and not _is_sparse(_document(path)):  # It was measured without sparse values.
        measured = [float(x) for x in row["measured_extent_native"].split("x")]
        np.testing.assert_allclose(np.ptp(points, axis=0), measured, rtol=1e-4, atol=1e-5)


def _trimesh_reads(row) -> bool:
    """What trimesh does not decode, stumbles over or takes 12 s for is left out."""
    document = _document(ASSETS / row["path"])
    return not (_is_sparse(document) or document.get("extensionsRequired") or len(document["nodes"]) > 100)


@shared
@pytest.mark.parametrize(
    "row", [r for r in rows() if r["outcome"] == "accept" and _trimesh_reads(r)], ids=lambda r: r["id"]
)
def test_good_files_agree_with_an_independent_reader(row):
    path = ASSETS / row["path"]
    outcome = read_gltf(SourceFile(path, asset_root(row["path"])))
    assert outcome.value is not None
    points = np.concatenate([m.points for m in outcome.value.meshes])
    reference = trimesh.load_scene(path).to_mesh()
    assert outcome.value.triangle_count == len(reference.faces)
    np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], reference.bounds, rtol=1e-5, atol=1e-6)
    mine = trimesh.Trimesh(points, _all_triangles(outcome.value.meshes), process=False)
    assert mine.area == pytest.approx(reference.area, rel=1e-4)
    assert mine.volume == pytest.approx(reference.volume, rel=1e-3, abs=1e-7)


def _all_triangles(meshes: tuple[Mesh, ...]) -> np.ndarray:
    starts = np.cumsum([0, *(len(m.points) for m in meshes)])
    return np.concatenate([m.triangles + start for m, start in zip(meshes, starts, strict=False)])
