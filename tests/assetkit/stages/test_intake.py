"""Intake gives every mesh of an object an id of its own, whatever the source calls it."""

from __future__ import annotations

from pathlib import Path

import trimesh

from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.sources.discover import discover
from assetkit.stages.intake import ReadSource


def test_meshes_have_ids_from_intake_on(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    for x_m, name in ((0.0, "lid ü"), (0.09, "lid u"), (9.0, "base")):
        box = trimesh.creation.box((0.1, 0.1, 0.1))
        box.apply_translation((x_m, 0.0, 0.0))
        scene.add_geometry(box, node_name=name, geom_name=name)
    file = tmp_path / "boxes.glb"
    scene.export(file, file_type="glb")
    objects = ReadSource().run(discover([file])[0], Options()).objects
    ids = sorted(list(item.model.meshes_by_id) for item in objects)
    assert ids == [["base"], ["lid_u", "lid_u_2"]]
    made = [canonicalize(item, file.name, Options()).value for item in objects]
    assert sorted([mesh.id for mesh in canonical.meshes] for canonical in made if canonical) == ids
