"""One object, written in every unit and every format that can say it, has one released size."""

import base64
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import METERS_PER_UNIT, Options
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource
from tests.support.bad_inputs.assets import gltf_json, obj_text, text

Extent = tuple[float, float, float]
LONG = {"mm": "millimeters", "cm": "centimeters", "in": "inches", "m": "meters"}
# Written with the source's up axis along the third extent; each maker gets a mesh in `unit`.
Maker = Callable[[Path, trimesh.Trimesh, str], Path]


def y_up(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The z-up mesh as a y-up file stores it."""
    return trimesh.Trimesh(mesh.vertices[:, [0, 2, 1]] * [1, 1, -1], mesh.faces, process=False)


def usda(mesh: trimesh.Trimesh, metadata: str) -> str:
    points = ", ".join(f"({x:.17g}, {y:.17g}, {z:.17g})" for x, y, z in mesh.vertices)
    counts = ", ".join(["3"] * len(mesh.faces))
    faces = ", ".join(map(str, mesh.faces.ravel()))
    return (
        f'#usda 1.0\n(\n    {metadata}\n)\ndef Mesh "m"\n{{\n    point3f[] points = [{points}]\n'
        f"    int[] faceVertexCounts = [{counts}]\n    int[] faceVertexIndices = [{faces}]\n}}\n"
    )


def write_usd(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    metadata = f'metersPerUnit = {METERS_PER_UNIT[unit]!r}\n    upAxis = "Z"'
    return text("part.usda", usda(mesh, metadata))(folder)


def write_usd_y_up(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    metadata = f'metersPerUnit = {METERS_PER_UNIT[unit]!r}\n    upAxis = "Y"'
    return text("part.usda", usda(y_up(mesh), metadata))(folder)


def write_dae(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    numbers = " ".join(f"{v:.17g}" for v in mesh.vertices.ravel())
    faces = " ".join(map(str, mesh.faces.ravel()))
    content = f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="{LONG[unit]}" meter="{METERS_PER_UNIT[unit]!r}"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="{mesh.vertices.size}">{numbers}
</float_array><technique_common><accessor source="#a" count="{len(mesh.vertices)}" stride="3"><param name="X"/>
<param name="Y"/><param name="Z"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION"
source="#p"/></vertices><triangles count="{len(mesh.faces)}"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{faces}</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/>
</scene></COLLADA>"""
    return text("part.dae", content)(folder)


def write_gltf(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    """glTF knows metres only: another unit is a scale of the node, as converters write it."""
    points, faces = y_up(mesh).vertices.astype("<f4").tobytes(), mesh.faces.astype("<u2").tobytes()
    uri = "data:;base64," + base64.b64encode(points + faces).decode()
    document: dict[str, Any] = gltf_json(
        buffers=[{"byteLength": len(points) + len(faces), "uri": uri}],
        bufferViews=[
            {"buffer": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(faces)},
        ],
        nodes=[{"mesh": 0, "scale": [METERS_PER_UNIT[unit]] * 3}],
    )
    document["accessors"][0]["count"] = len(mesh.vertices)
    document["accessors"][1]["count"] = mesh.faces.size
    return text("part.gltf", json.dumps(document))(folder)


def write_obj(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    return text("part.obj", obj_text(mesh, f"# Units: {LONG[unit]}\n"))(folder)


def write_ply(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    content = mesh.export(file_type="ply", encoding="ascii")
    assert isinstance(content, bytes)
    return text(
        "part.ply", content.replace(b"format ascii 1.0\n", f"format ascii 1.0\ncomment unit {unit}\n".encode())
    )(folder)


def write_stl(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    content = mesh.export(file_type="stl")
    assert isinstance(content, bytes)
    return text("part.stl", struct.pack("<80s", f"COLOR= UNITS={unit}".encode()) + content[80:])(folder)


def write_named_stl(folder: Path, mesh: trimesh.Trimesh, unit: str) -> Path:
    path = folder / f"part_{LONG[unit]}.stl"
    content = mesh.export(file_type="stl")
    assert isinstance(content, bytes)
    path.write_bytes(content)
    return path


MAKERS: dict[str, Maker] = {
    "usd": write_usd,
    "usd y-up": write_usd_y_up,
    "dae": write_dae,
    "gltf": write_gltf,
    "obj": write_obj,
    "ply": write_ply,
    "stl": write_stl,
    "stl by name": write_named_stl,
}


def released_extent(file: Path, options: Options) -> Extent:
    [item] = ReadSource().run(discover([file])[0], options).objects
    outcome = canonicalize(item, file.name, options)
    assert outcome.value is not None
    assert not outcome.review
    assert outcome.value.meters_per_unit.confidence >= 0.5
    return outcome.value.section.extent_m.value


@pytest.mark.parametrize("unit", METERS_PER_UNIT)
@pytest.mark.parametrize("maker", MAKERS)
def test_the_declared_unit_gives_the_true_size(maker: str, unit: str, tmp_path: Path):
    extent_m = (0.0823, 1.7311, 0.3257)
    box = trimesh.creation.box(np.array(extent_m) / METERS_PER_UNIT[unit])
    file = MAKERS[maker](tmp_path, box, unit)
    assert released_extent(file, Options()) == pytest.approx(extent_m, rel=1e-6)


@pytest.mark.parametrize("unit", ["mm", "cm", "m", "in"])
def test_the_users_unit_gives_the_true_size_whatever_the_file_says(unit: Any, tmp_path: Path):
    box = trimesh.creation.box(np.array([0.1, 0.2, 0.3]) / METERS_PER_UNIT[unit])
    other = "cm" if unit != "cm" else "mm"
    for maker in (write_obj, write_usd, write_dae):
        file = maker(tmp_path, box, other)
        assert released_extent(file, Options(units=unit)) == pytest.approx((0.1, 0.2, 0.3), rel=1e-6)
