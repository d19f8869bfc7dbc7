"""Near-duplicates of a library of packages: copies are reported and both stay, other objects are not, work is kept."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from assetkit.library import catalog
from assetkit.library.near_duplicates import groups_of, near_duplicates, refresh_near_duplicates
from assetkit.library.preview_worker import first_model
from geom.features.shape_descriptor import shape_descriptor
from geom.mesh.decimate import decimate
from geom.mesh.edit import merge_surfaces
from jobs.cache import file_sha256
from schemas.arrays import FloatArray, IntArray
from tests.support.package_samples import content, mesh_from, model
from usdio.write.package import write_package

SAMPLE = Path(__file__).parents[2] / "data" / "record.json"
TURN = Rotation.from_euler("xyz", [40.0, -73.0, 110.0], degrees=True).as_matrix()


def add(out: Path, name: str, points: FloatArray, triangles: IntArray) -> None:
    """A package with these visible triangles, and the parts of a record that the catalog reads."""
    mesh = mesh_from(trimesh.Trimesh(points, triangles, process=False))
    shutil.rmtree(out / name, ignore_errors=True)
    write_package(content(model([mesh]), asset_id=name), out / name)
    shape = shape_descriptor(points, triangles)
    assert shape is not None
    record: dict[str, Any] = json.loads(SAMPLE.read_text()) | {"asset_id": name}
    record["geometry"]["shape"] = shape.model_dump(mode="json")
    files = sorted(p for p in (out / name).rglob("*") if p.is_file())
    record["hashes"] = {p.relative_to(out / name).as_posix(): file_sha256(p) for p in files}
    (out / name / "record.json").write_text(json.dumps(record))


def add_body(out: Path, name: str, body: trimesh.Trimesh, scale: float = 1.0) -> None:
    add(out, name, scale * np.array(body.vertices) @ TURN.T, np.array(body.faces, dtype=np.int32))


def refreshed(out: Path) -> int:
    catalog.update(out)
    return refresh_near_duplicates(out)


def pairs(out: Path) -> list[tuple[str, str, float]]:
    return [(pair.asset_id, pair.other_id, round(pair.scale_ratio, 3)) for pair in near_duplicates(out)]


def test_copies_are_reported_and_compared_once(tmp_path: Path):
    cone = trimesh.creation.cone(0.05, 0.1)
    add(tmp_path, "cone", np.array(cone.vertices), np.array(cone.faces, dtype=np.int32))
    add_body(tmp_path, "half_cone", cone.subdivide(), scale=0.5)
    add_body(tmp_path, "flat_cone", trimesh.creation.cone(0.05, 0.095))  # A candidate that is another shape.
    add_body(tmp_path, "box", trimesh.creation.box((0.3, 0.2, 0.1)))
    assert refreshed(tmp_path) == 3
    assert pairs(tmp_path) == [("cone", "half_cone", 0.5)]
    assert refreshed(tmp_path) == 0
    assert [row["asset_id"] for row in catalog.listing(tmp_path)] == ["box", "cone", "flat_cone", "half_cone"]

    add_body(tmp_path, "box", trimesh.creation.cone(0.05, 0.1), scale=2.0)  # Another object under the same name.
    assert refreshed(tmp_path) > 0
    assert groups_of(near_duplicates(tmp_path)) == [("box", "cone", "half_cone")]
    shutil.rmtree(tmp_path / "cone")
    refreshed(tmp_path)
    updated = comparisons(tmp_path)
    catalog.rebuild(tmp_path)
    refresh_near_duplicates(tmp_path)
    assert comparisons(tmp_path) == updated
    assert groups_of(near_duplicates(tmp_path)) == [("box", "half_cone")]


def test_many_equal_objects_cost_one_comparison_each(tmp_path: Path):
    box = trimesh.creation.box((0.3, 0.2, 0.1))
    for k in range(6):
        add(tmp_path, f"box_{k}", (1 + k) * np.array(box.vertices), np.array(box.faces, dtype=np.int32))
    assert refreshed(tmp_path) == 5
    assert groups_of(near_duplicates(tmp_path)) == [tuple(f"box_{k}" for k in range(6))]


def test_a_package_that_cannot_be_read_is_noted_and_the_others_are_compared(tmp_path: Path):
    cone = trimesh.creation.cone(0.05, 0.1)
    for name in ("a", "b", "c"):
        add(tmp_path, name, np.array(cone.vertices), np.array(cone.faces, dtype=np.int32))
    for layer in (tmp_path / "b").rglob("*.usd*"):
        layer.write_text("no layer")
    assert refreshed(tmp_path) == 2
    assert pairs(tmp_path) == [("a", "c", 1.0)]
    assert refreshed(tmp_path) == 0


def comparisons(out: Path) -> Sequence[tuple[object, ...]]:
    with closing(sqlite3.connect(out / catalog.CATALOG)) as db:
        return db.execute("SELECT * FROM comparisons ORDER BY 1, 2").fetchall()


OBJECTS = {  # Cans and wheels are pairs of one category.
    "soup_can": "urdf/ycb_005_tomato_soup_can_urdf/textured_simple_reoriented.obj",
    "coffee_can": "obj/ycb_002_master_chef_can_obj/textured_simple_reoriented.obj",
    "wheel": "usd/uwg_car_sedan/assets/wheels/wheelNormal/geo/wheelNormalGeo.usda",
    "red_wheel": "usd/uwg_car_sedan/assets/wheels/wheelRed/geo/wheelRedGeo.usd",
    "duck": "glb/khr_duck_glb/Duck.glb",
}


@pytest.mark.shared
def test_copies_of_real_objects_are_reported_and_others_of_their_category_are_not(shared_assets: Path, tmp_path: Path):
    for name, file in OBJECTS.items():
        points, triangles, _ = merge_surfaces(first_model(shared_assets / file).meshes)
        add(tmp_path, name, points, triangles)
        add(tmp_path, f"{name}_turned", 0.37 * points @ TURN.T, triangles[::-1].copy())
        if len(triangles) > 1000:
            add(tmp_path, f"{name}_light", *decimate(points, triangles, int(0.6 * len(triangles))))
    points, triangles, _ = merge_surfaces(first_model(shared_assets / "dae/khr_duck_dae/Duck.dae").meshes)
    add(tmp_path, "duck_again", points, triangles)
    refreshed(tmp_path)
    expected = {
        "coffee_can": ("coffee_can", "coffee_can_light", "coffee_can_turned"),
        "duck": ("duck", "duck_again", "duck_light", "duck_turned"),
        "red_wheel": ("red_wheel", "red_wheel_turned"),
        "soup_can": ("soup_can", "soup_can_light", "soup_can_turned"),
        "wheel": ("wheel", "wheel_turned"),
    }
    assert groups_of(near_duplicates(tmp_path)) == sorted(expected.values())
