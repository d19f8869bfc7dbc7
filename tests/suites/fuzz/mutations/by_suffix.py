"""Which damage fits which kind of file; `mutate` applies one to three of them."""

from __future__ import annotations

from random import Random

from tests.suites.fuzz.mutations.archives import edit_package, odd_picture_size
from tests.suites.fuzz.mutations.hdf5 import edit_hdf5
from tests.suites.fuzz.mutations.raw_bytes import BINARY, Mutation
from tests.suites.fuzz.mutations.text import TEXT
from tests.suites.fuzz.mutations.trees import double_key, edit_json, edit_yaml, odd_yaml
from tests.suites.fuzz.mutations.xml import declare_entities, edit_robot, edit_xml, include_itself

_XML: tuple[Mutation, ...] = (*[edit_xml] * 6, declare_entities, declare_entities)
_ROBOT: tuple[Mutation, ...] = (*_XML, *[edit_robot] * 12, include_itself, *TEXT, *BINARY)
_HDF5: tuple[Mutation, ...] = (*[edit_hdf5] * 20, *BINARY)
BY_SUFFIX: dict[str, tuple[Mutation, ...]] = {
    ".obj": (*TEXT, *TEXT, *BINARY),
    ".mtl": (*TEXT, *BINARY),
    ".ply": (*TEXT, *BINARY),
    ".stl": (*TEXT, *BINARY, *BINARY),
    ".gltf": (*[edit_json] * 12, double_key, *TEXT, *BINARY),
    ".glb": (*[edit_json] * 12, double_key, *BINARY),
    ".dae": (*_XML, *_XML, *TEXT, *BINARY),
    ".urdf": _ROBOT,
    ".xml": _ROBOT,
    ".usda": (*TEXT, *TEXT, *TEXT, *BINARY),
    ".usdc": BINARY,
    ".usd": (*TEXT, *BINARY),
    ".usdz": (*[edit_package] * 8, *BINARY),
    ".yaml": (*[edit_yaml] * 12, odd_yaml, odd_yaml, odd_yaml, *TEXT, *BINARY[:4]),
    ".json": (*[edit_json] * 16, double_key, *TEXT, *BINARY[:4]),
    ".hdf5": _HDF5,
    ".h5": _HDF5,
    ".csv": (*TEXT, *TEXT, *BINARY),
    ".png": (odd_picture_size, odd_picture_size, *BINARY),
}
MOST_BYTES = 20_000_000  # that are damaged once more


def mutate(rng: Random, data: bytes, suffix: str) -> tuple[bytes, str]:
    """`data` damaged once to three times by what fits its kind, and the names of what was done."""
    names: list[str] = []
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if not 0 < len(data) <= MOST_BYTES:
            break
        mutation = rng.choice(BY_SUFFIX.get(suffix.lower(), BINARY))
        data = mutation(rng, data)
        names.append(mutation.__name__)
    return data, "+".join(names)
