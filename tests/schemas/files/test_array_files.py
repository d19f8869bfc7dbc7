from pathlib import Path

import numpy as np

from schemas.appearance.material import Material, Texture, TextureUse
from schemas.evidence import declared, default
from schemas.files import array_files
from schemas.model import Mesh, Model, Node


def sample() -> Model:
    mesh = Mesh("a", np.eye(3), np.array([[0, 1, 2]], np.int32), uvs=(np.zeros((1, 3, 2), np.float32),), material=0)
    return Model(
        (mesh,),
        (Material("m", base_color_texture=TextureUse("t", uv_offset=(0.5, 0.0)), unmapped={"sheen": [1, 2]}),),
        (Texture("t", b"\x89PNG\x00", "png", 1, 1),),
        (Node("/root", np.eye(4), (0,)),),
        declared(0.01, "file", inputs=("a.obj",)),
        default("y"),
        hints=("units: cm",),
    )


def test_round_trip_keeps_every_value(tmp_path: Path):
    before = sample()
    array_files.save(before, Model, tmp_path / "model.npz")
    after = array_files.load(Model, tmp_path / "model.npz")
    assert np.array_equal(after.meshes[0].points, before.meshes[0].points)
    assert after.meshes[0].triangles.dtype == np.int32
    assert after.materials == before.materials
    assert after.textures == before.textures
    assert (after.meters_per_unit, after.up_axis, after.hints) == (before.meters_per_unit, before.up_axis, before.hints)


def test_same_value_same_bytes(tmp_path: Path):
    array_files.save(sample(), Model, tmp_path / "a.npz")
    array_files.save(sample(), Model, tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
