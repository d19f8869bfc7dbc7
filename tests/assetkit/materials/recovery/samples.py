"""Boxes of a model with and without materials, for tests of recovery."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh

from assetkit.materials.recovery.surfaces import RecoverySubject
from schemas.appearance.material import Material
from schemas.evidence import Evidence, declared, default
from schemas.model import Mesh, Model

UNKNOWN = default("unknown")
MUG = declared("mug", "test")


def box(name: str, material: int | None = None, at_m: float = 0.0) -> Mesh:
    """A cube of 10 cm at the height `at_m`."""
    shape = trimesh.creation.box((0.1, 0.1, 0.1)).apply_translation((0.0, 0.0, at_m))
    triangles = np.array(shape.faces, dtype=np.int32)
    return Mesh(name, np.array(shape.vertices), triangles, material=material, source_path=f"/{name}", id=name)


def model_of(meshes: Sequence[Mesh], materials: Sequence[Material] = ()) -> Model:
    return Model(tuple(meshes), tuple(materials), (), (), default(1.0), default("z"))


def subject(category: Evidence[str] = UNKNOWN, file_name: str = "thing") -> RecoverySubject:
    return RecoverySubject(category, file_name)
