"""The damage that the fuzz suite does: the same for the same seed, never a failure of its own; a slice of the suite."""

import json
from pathlib import Path
from random import Random

import pytest

from tests.suites.fuzz import run
from tests.suites.fuzz.cases import make_case
from tests.suites.fuzz.mutations.by_suffix import BY_SUFFIX, mutate
from tests.suites.fuzz.readers.by_format import READERS
from tests.suites.fuzz.seeds import asset_seeds, seeds_of
from tests.support.bad_inputs.assets import CUBE, gltf_json, obj_text, usda
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
}


# Of 60: text without numbers, and what is no HDF5 or picture, can be damaged in fewer ways.
LEAST_COPIES = {".usdz": 8, ".hdf5": 8, ".h5": 8, ".png": 8}


@pytest.mark.parametrize("suffix", sorted(BY_SUFFIX))
def test_damage_is_deterministic_and_total(suffix: str):
    data = SAMPLES.get(suffix, b"PXR-USDC" + bytes(200))
    copies = [mutate(Random(i), data, suffix) for i in range(60)]
    assert copies == [mutate(Random(i), data, suffix) for i in range(60)]
    assert len({damaged for damaged, _ in copies}) > LEAST_COPIES.get(suffix, 30)


def test_a_case_is_the_same_on_every_run(tmp_path: Path):
    folder = tmp_path / "seeds"
    folder.mkdir()
    usda()(folder)
    [seed] = asset_seeds([folder])
    for number in range(20):
        (_, first, done), (_, again, redone) = (
            make_case(f"0:{number}", seed, tmp_path / f"{k}_{number}") for k in "ab"
        )
        assert (first.name, done) == (again.name, redone)
        if first.is_file() and not first.is_symlink():
            assert first.read_bytes().replace(b"/a_", b"/b_") == again.read_bytes().replace(b"/a_", b"/b_")


def test_a_sound_file_breaks_no_promise(tmp_path: Path):
    note = READERS["usd"](tmp_path, usda()(tmp_path))
    assert (note.made, note.broken, note.trace) == (1, [], "")


def test_sound_scenes_and_plans_break_no_promise(tmp_path: Path):
    for seed in (*seeds_of("scene", tmp_path, 2), *seeds_of("plan", tmp_path, 1)):
        note = READERS[seed.format](seed.folder, seed.file)
        assert (note.broken, note.trace) == ([], "")


def test_a_slice_of_the_suite_finds_nothing(tmp_path: Path):
    """One format through a cell, as `make fuzz` runs all."""
    argv = ["--files", "2", "--mutations", "5", "--seed", "1", "--format", "stl"]
    assert run.main([*argv, "--out", str(tmp_path)]) == 0
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


@pytest.mark.long
def test_all_formats_find_nothing(tmp_path: Path):
    assert run.main(["--files", "4", "--mutations", "20", "--seed", "2", "--out", str(tmp_path)]) == 0
