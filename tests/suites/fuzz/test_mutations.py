"""The damage that the fuzzer does: the same for the same seed, and never a failure of its own."""

import json
from pathlib import Path
from random import Random

import pytest

from tests.suites.fuzz.cases import make_case
from tests.suites.fuzz.mutations.by_suffix import BY_SUFFIX, mutate
from tests.suites.fuzz.readers import asset
from tests.suites.fuzz.seeds import asset_seeds
from tests.support import replay_samples
from tests.support.bad_inputs.assets import CUBE, gltf_json, obj_text, usda
from tests.support.bad_inputs.gap import FREE
from tests.support.bad_inputs.robot import inertial, joint, link, mjcf, shape, urdf

_HINGE = '<axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/>'
URDF = urdf(
    link("a", shape('<box size="1 1 1"/>') + inertial(1.0)),
    link("b", shape('<box size="1 1 1"/>')),
    joint("j", "a", "b", "revolute", _HINGE),
)
MJCF = mjcf('<body pos="0 0 1"><joint axis="0 0 1" range="-1 1" damping="1"/><geom size="1" mass="1"/></body>\n')
SAMPLES = {
    ".obj": obj_text(CUBE).encode(),
    ".gltf": json.dumps(gltf_json()).encode(),
    ".stl": CUBE.export(file_type="stl"),
    ".ply": CUBE.export(file_type="ply"),
    ".glb": CUBE.export(file_type="glb"),
    ".dae": b"<COLLADA><asset><unit meter='1'/></asset><library_geometries/></COLLADA>",
    ".usda": b"#usda 1.0\ndef Cube 'c' {}\n",
    ".usdz": b"PK\x03\x04 no archive",
    ".urdf": ("\n".join(URDF.values())).encode(),
    ".xml": ("\n".join(MJCF.values())).encode(),
    ".mtl": b"newmtl a\nKd 1 0 0\n",
    ".yaml": FREE.encode(),
    ".json": json.dumps(gltf_json()).encode(),
    ".csv": b"t,x\n0,1\n1,2\n",
}


@pytest.mark.parametrize("suffix", sorted(BY_SUFFIX))
def test_damage_is_deterministic_and_total(suffix: str, tmp_path: Path):
    data = SAMPLES.get(suffix, b"PXR-USDC" + bytes(200))
    if suffix in (".hdf5", ".h5"):
        data = replay_samples.robomimic(tmp_path / "d.hdf5", demos=1).read_bytes()
    count = 6 if suffix in (".hdf5", ".h5") else 60  # their library is slow
    made = [mutate(Random(i), data, suffix) for i in range(count)]
    assert made == [mutate(Random(i), data, suffix) for i in range(count)]
    assert len({m for m, _ in made}) > count // 2


def test_a_case_is_the_same_on_every_run(tmp_path: Path):
    folder = tmp_path / "seeds"
    folder.mkdir()
    usda()(folder)
    [seed] = asset_seeds([folder])
    first, again = (make_case("0:1", seed, tmp_path / name) for name in ("a", "b"))
    assert first[1].name == again[1].name
    assert first[2] == again[2]
    assert first[1].read_bytes() == again[1].read_bytes()


def test_a_sound_file_breaks_no_promise(tmp_path: Path):
    note = asset.read(tmp_path, usda()(tmp_path))
    assert (note.made, note.broken, note.trace) == (1, [], "")
