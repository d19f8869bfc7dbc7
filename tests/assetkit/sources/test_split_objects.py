from dataclasses import replace

import numpy as np
import trimesh

from assetkit.sources.split_objects import split_objects
from schemas.appearance.material import Material
from schemas.evidence import declared
from schemas.model import Mesh, Model
from tests.support.bad_inputs.assets import joined


def model_of(*boxes: tuple[tuple[float, float, float], float], one_mesh: bool = False) -> Model:
    parts = [trimesh.creation.box((size,) * 3) for _, size in boxes]
    for part, (centre, _) in zip(parts, boxes, strict=True):
        part.apply_translation(centre)
    if one_mesh:
        parts = [joined(*parts)]
    meshes = tuple(
        Mesh(f"m{i}", np.asarray(p.vertices), np.asarray(p.faces, dtype=np.int32), material=i)
        for i, p in enumerate(parts)
    )
    return Model(
        meshes,
        tuple(Material(f"mat{i}") for i in range(len(meshes))),
        (),
        (),
        declared(1.0, "test"),
        declared("z", "test"),
    )


def test_touching_and_near_parts_are_one_object():
    model = model_of(((0, 0, 0), 1.0), ((1.0, 0, 0), 1.0), ((2.2, 0, 0), 1.0))
    assert split_objects(model) == (model,)


def test_far_apart_parts_become_objects_with_their_own_materials():
    model = model_of(((0, 0, 0), 1.0), ((5, 0, 0), 2.0))
    objects = split_objects(model)
    assert [len(o.meshes) for o in objects] == [1, 1]
    assert [o.materials[0].name for o in objects] == ["mat1", "mat0"]
    assert all(o.meshes[0].material == 0 for o in objects)


def test_one_mesh_is_cut_along_its_pieces_and_nothing_is_lost():
    model = model_of(((0, 0, 0), 1.0), ((5, 0, 0), 1.0), ((0, 5, 0), 1.0), one_mesh=True)
    uv = np.arange(36 * 6, dtype=np.float32).reshape(36, 3, 2)
    model = replace(model, meshes=(replace(model.meshes[0], uvs=(uv,)),))
    objects = split_objects(model)
    assert len(objects) == 3
    assert sum(len(o.meshes[0].triangles) for o in objects) == 36
    assert sorted(v for o in objects for v in o.meshes[0].uvs[0].ravel()) == sorted(uv.ravel())


def test_a_fragment_stays_with_its_nearest_piece():
    model = model_of(((0, 0, 0), 1.0), ((0.9, 0, 0), 0.01))
    assert len(split_objects(model)) == 1
