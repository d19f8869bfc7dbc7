"""A small asset library for scene tests: cubes, a rod that falls over, an open bin, a package that is torn."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from jobs.cache import file_sha256
from schemas.physics import CollisionShape
from tests.support import package_samples as samples
from tests.support.scene.articulated import articulated_library
from usdio.write.package import write_package

RECORD = Path(__file__).parents[2] / "data" / "record.json"
CUBE_M = 0.06
# An open bin: 0.2 x 0.15 outside, walls and floor of 1 cm, 8 cm high.
BIN: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "floor": ((0.2, 0.15, 0.01), (0.0, 0.0, 0.005)),
    "left": ((0.01, 0.15, 0.07), (-0.095, 0.0, 0.045)),
    "right": ((0.01, 0.15, 0.07), (0.095, 0.0, 0.045)),
    "front": ((0.18, 0.01, 0.07), (0.0, -0.07, 0.045)),
    "rear": ((0.18, 0.01, 0.07), (0.0, 0.07, 0.045)),
}
_INSIDE = {"outline_m": [[-0.09, -0.065], [0.09, -0.065], [0.09, 0.065], [-0.09, 0.065]]}
_FLOOR: dict[str, Any] = {"anchor_id": "surface_0", "kind": "surface", "position_m": [0, 0, 0.01], "polygon": _INSIDE}
_FLOOR |= {"normal": [0, 0, 1], "area_m2": 0.0234, "clearance_m": None, "load_directions": [[0, 0, 1]]}
_HOLD: dict[str, Any] = {"anchor_id": "volume_0", "kind": "volume", "position_m": [0, 0, 0.01], "opening": _INSIDE}
_HOLD |= {"direction": [0, 0, 1], "height_m": 0.07, "volume_m3": 0.00164, "passes_m": 0.13}
_HOLD |= {"slices": [{"height_m": 0.0175 + 0.035 * i, "polygons": [_INSIDE]} for i in range(2)]}


def cube(library: Path, asset_id: str = "cube", outcome: str = "accepted") -> None:
    """A solid cube without known stable poses."""
    block(library, asset_id, (CUBE_M, CUBE_M, CUBE_M), outcome)


def block(library: Path, asset_id: str, size_m: tuple[float, float, float], outcome: str = "accepted") -> None:
    """A solid block without known stable poses."""
    shape = CollisionShape("box", size_m, samples.at(0.5 * size_m[2]))
    _package(library, asset_id, [samples.box_mesh(size_m)], [shape], ["manipulated"], [], outcome=outcome)


def rod(library: Path) -> None:
    """A box that was authored on its end, and falls onto its side."""
    mesh, size_m = samples.box_mesh((0.01, 0.01, 0.2)), (0.01, 0.01, 0.2)
    lying = {"quat_wxyz": [0.5**0.5, 0.5**0.5, 0.0, 0.0], "support_offset_m": 0.005, "probability": 1.0}
    _package(library, "rod", [mesh], [CollisionShape("box", size_m, samples.at(0.1))], ["manipulated"], [], [lying])


def open_bin(library: Path, asset_id: str = "bin", floor_m: float | None = None) -> None:
    """The bin, with the surface and the volume that its inside is; `floor_m`: level over a square of that size only."""
    meshes = [samples.box_mesh(size, name, (x, y, z - size[2] / 2)) for name, (size, (x, y, z)) in BIN.items()]
    shapes = []
    for size, centre in BIN.values():
        X_AS = samples.at(0.0)
        X_AS[:3, 3] = centre
        shapes.append(CollisionShape("box", size, X_AS))
    hold = _HOLD
    if floor_m is not None:
        half = 0.5 * floor_m
        floor = {"outline_m": [[-half, -half], [half, -half], [half, half], [-half, half]]}
        hold = _HOLD | {"slices": [{"height_m": 0.0175, "polygons": [floor]}, _HOLD["slices"][1]]}
    _package(library, asset_id, meshes, shapes, ["receptacle"], [_FLOOR, hold])


def library(folder: Path, cubes: int = 17) -> Path:
    """All of them: `cube`, `cube_0` and on, `rod`, `bin`, `bowl` (round), `doubtful` (in review), `tried` (exercised
    over ranges), `mug` (with parts), `torn`, and the articulated ones."""
    cube(folder)
    cube(folder, "doubtful", outcome="review")
    tried(folder)
    rod(folder)
    for i in range(cubes):
        cube(folder, f"cube_{i}")
    open_bin(folder)
    open_bin(folder, "bowl", floor_m=0.02)
    articulated_library(folder)
    mug(folder)
    (folder / "torn").mkdir()
    (folder / "torn" / "record.json").write_text("{")
    return folder


def mug(library: Path) -> None:
    """A block with a handle toward +y, and a lid over its origin."""
    block(library, "mug", (0.06, 0.08, 0.09))
    file = library / "mug" / "record.json"
    record = json.loads(file.read_text())
    measured = {"source": "measured", "method": "test", "confidence": 1.0}
    boxes = {"handle": ([-0.01, 0.03, 0.02], [0.01, 0.05, 0.07]), "lid": ([-0.03, -0.03, 0.09], [0.03, 0.03, 0.09])}
    record["parts"] = [
        {"value": {"part_id": f"part_{k}", "label": {"value": name, **measured}, "name": name, "sources": ["shape"],
                   "faces": [], "triangles": 1, "area_m2": 0.001, "low_m": low, "high_m": high}, **measured}
        for k, (name, (low, high)) in enumerate(boxes.items())
    ]  # fmt: skip
    spout = {"kind": "spout", "affordance_id": "spout_0", "task": "pour", "interaction": "tilt", "size_m": 0.01}
    spout |= {"position_m": [-0.03, 0.0, 0.09], "direction": [-1, 0, 0], "outline_m": []}
    record["affordances"] = [{"value": spout, **measured}]
    file.write_text(json.dumps(record))


def tried(library: Path) -> None:
    """A cube that a gripper carried from friction 0.4 on, and at up to twice its mass."""
    cube(library, "tried")
    file = library / "tried" / "record.json"
    record = json.loads(file.read_text())
    mass_kg = record["physics"]["mass_kg"]["value"]
    margins = [
        {"quantity": "friction", "low": 0.4, "high": 0.9, "bounds": [0.2, 0.9]},
        {"quantity": "mass_kg", "low": 0.5 * mass_kg, "high": 2.0 * mass_kg, "bounds": [0.5 * mass_kg, 2.0 * mass_kg]},
    ]
    record["acceptance"]["suites"] = [{"name": "manipulated", "outcome": "passed", "margins": margins}]
    file.write_text(json.dumps(record))


def _package(
    library: Path,
    asset_id: str,
    meshes: list,
    shapes: list[CollisionShape],
    roles: list[str],
    anchors: list[dict],
    stable: list[dict] | None = None,
    outcome: str = "accepted",
) -> None:
    content = samples.content(samples.model(meshes), shapes, asset_id=asset_id)
    write_package(content, library / asset_id)
    files = sorted(file for file in (library / asset_id).rglob("*") if file.is_file())
    hashes = {file.relative_to(library / asset_id).as_posix(): file_sha256(file) for file in files}
    record = json.loads(RECORD.read_text()) | {"asset_id": asset_id, "outcome": outcome, "hashes": hashes}
    measured = {"source": "measured", "method": "test", "confidence": 1.0}
    record["semantics"]["roles"] = [{"value": role, **measured} for role in roles]
    record["anchors"] = [{"value": anchor, **measured} for anchor in anchors]
    record["acceptance"]["stable_poses"] = [{"value": pose, **measured} for pose in stable or []]
    (library / asset_id / "record.json").write_text(json.dumps(record))
