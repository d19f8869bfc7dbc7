"""Poses of the copies of a mesh that one node draws (EXT_mesh_gpu_instancing)."""

from __future__ import annotations

from typing import Final

import numpy as np

from assetkit.readers.gltf.accessors import Accessors
from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.nodes import rotations
from schemas.diagnostics import InvalidInput, finding

NAME: Final = "EXT_mesh_gpu_instancing"
MAX_INSTANCES: Final = 1000


def instances(node: Json, accessors: Accessors) -> np.ndarray | None:
    """(k, 4, 4) poses of the copies in the node's frame, translation after rotation after scale; None without any.

    Raises InvalidInput: `asset/schema-error` for attributes of different length or type, `asset/resource-limit` for
    more than 1,000 copies.
    """
    extension = node.extension(NAME)
    if extension is None:
        return None
    described = extension.require("attributes")
    types = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}
    arrays = {
        name: accessors.read(reference, kind).astype(np.float64)
        for name, kind in types.items()
        if (reference := described.get(name)) is not None
    }
    counts = {len(a) for a in arrays.values()}
    if len(counts) != 1:
        raise described.schema_error(f"instance attributes of {sorted(counts)} elements")
    count = counts.pop()
    if count > MAX_INSTANCES:
        headline = f"the node draws {count} copies of its mesh"
        raise InvalidInput(
            finding("asset/resource-limit", headline, where=extension.where, value=count, bound=MAX_INSTANCES)
        )
    X = np.tile(np.eye(4), (count, 1, 1))
    if "ROTATION" in arrays:
        X[:, :3, :3] = rotations(arrays["ROTATION"])
    if "SCALE" in arrays:
        X[:, :3, :3] *= arrays["SCALE"][:, None, :]
    if "TRANSLATION" in arrays:
        X[:, :3, 3] = arrays["TRANSLATION"]
    return X
