"""`mana gap extend` on a real object: the numbers arrive in USD, URDF and record, and the judges have the last word."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pybullet
import pytest
from typer.testing import CliRunner

from assetkit.library.judge_file import validate_file
from assetkit.package.record import read_record
from cli.gap.extend import _body, extend
from cli.main import app
from jobs.cache import file_sha256
from jobs.lock import FolderInUse, exclusive
from schemas.asset import AssetRecord
from schemas.diagnostics import InvalidInput, Severity
from schemas.sim_gap.extension import AppliedEffect, Estimate, ModelExtension, Place
from sim.effects.library import EFFECTS
from simgap.extension.exportable import MeasuredBody, joint_physics, package_physics
from simgap.extension.extension import read_extension
from simgap.recording.read import read
from usdio.reread.body import reread_body

RUN = CliRunner()
Values = dict[str, tuple[float, float, float]]  # value, low, high
FOUND: dict[str, Values] = {
    "contact.friction": {"mu": (0.21, 0.19, 0.23)},
    "contact.restitution": {"restitution": (0.3, 0.25, 0.35)},
    "body.mass": {"mass_kg": (0.02, 0.019, 0.021)},
    "body.inertia": {"factor": (1.1, 1.05, 1.15)},
    "body.com_offset": {"x_m": (0.001, 0.0, 0.002), "y_m": (0.0, 0.0, 0.0), "z_m": (-0.002, -0.003, -0.001)},
    "contact.rolling_friction": {"lever_m": (0.0005, 0.0004, 0.0006)},
    "world.linear_drag": {"drag_Nspm": (0.01, 0.0, 0.02)},
}


def extension(file: Path, found: dict[str, Values], measurement: str = "0" * 64, **where: str) -> Path:
    effects = tuple(
        AppliedEffect(
            name=name,
            where=Place(**where),
            parameters={n: Estimate(value=v, ci95=(low, high)) for n, (v, low, high) in values.items()},
        )
        for name, values in found.items()
    )
    file.write_text(ModelExtension(measurement=measurement, effects=effects).model_dump_json())
    return file


@pytest.fixture(scope="module")
def package(scene_packages: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The domino of pybullet_data as a package."""
    return shutil.copytree(scene_packages / "domino", tmp_path_factory.mktemp("library") / "domino")


@pytest.fixture(scope="module")
def tossed(package: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A measurement whose body is a box of the same size about its middle, evenly filled, of another mass."""
    folder = tmp_path_factory.mktemp("toss")
    record = read_record(package)
    assert record is not None
    (folder / "trajectories").mkdir()
    (folder / "measurement.yaml").write_text(
        "schema_version: 1\nname: toss\nkind: free_body\nrate_hz: 100.0\n"
        "columns: {t: t, p: [x, y, z], q_wxyz: [a, b, c, d]}\nsubject:\n"
        f"  box: {{size_m: {list(record.geometry.extent_m.value)}}}\n"
        "  mass_kg: 0.01\n"
    )
    t = np.arange(0.0, 0.3, 0.01)
    for k in range(3):
        rows = np.stack([t, *(np.full_like(t, v) for v in (0.0, 0.1 * k)), 1.0 - 4.905 * t**2], axis=1)
        rows = np.concatenate([rows, np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))], axis=1)
        path = folder / "trajectories" / f"t{k}.csv"
        np.savetxt(path, rows, delimiter=",", header="t,x,y,z,a,b,c,d", comments="")
    return folder


@pytest.fixture(scope="module")
def extended(package: Path, tossed: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    out = tmp_path_factory.mktemp("extended")
    value = read(tossed).value
    assert value is not None
    given = extension(out / "given.json", FOUND, value.content_hash)
    command = ["gap", "extend", str(package), str(given), "--measurement", str(tossed), "--out", str(out), "--json"]
    result = RUN.invoke(app, command)
    assert result.exit_code == 0, result.output
    return out / package.name, json.loads(result.output)


def record(folder: Path) -> AssetRecord:
    read_back = read_record(folder)
    assert read_back is not None
    return read_back


def expected_inertia(package: Path) -> np.ndarray:
    """1.1 times that of an even box of the package's mass: motion shows inertia per mass, not the 10 g declared."""
    squares = np.array(record(package).geometry.extent_m.value) ** 2
    return 1.1 * 0.02 / 12.0 * np.diag(squares.sum() - squares)


def test_every_judge_accepts_the_new_package(extended: tuple[Path, dict]):
    findings = validate_file(extended[0] / "usd" / f"{extended[0].name}.usda")
    assert [d.code for d in findings if d.severity is Severity.ERROR] == []


def test_usd_holds_what_was_measured(package: Path, extended: tuple[Path, dict]):
    body = reread_body(extended[0] / "usd" / f"{package.name}.usda")
    assert body.mass.mass_kg == pytest.approx(0.02)
    assert body.contact.dynamic_friction == body.contact.static_friction == pytest.approx(0.21)
    assert body.contact.restitution == pytest.approx(0.3)
    middle_m = 0.5 * record(package).geometry.extent_m.value[2]
    np.testing.assert_allclose(body.mass.centre_of_mass_m, [0.001, 0.0, middle_m - 0.002], atol=1e-6)
    np.testing.assert_allclose(body.mass.inertia_kgm2, expected_inertia(package), rtol=1e-5, atol=1e-11)


def test_the_twin_loads_in_the_engine_with_the_same_numbers(package: Path, extended: tuple[Path, dict]):
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(
            str(extended[0] / "export" / f"{package.name}.urdf"),
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
            physicsClientId=client,
        )
        info = pybullet.getDynamicsInfo(body, -1, physicsClientId=client)
    finally:
        pybullet.disconnect(client)
    assert info[0] == pytest.approx(0.02)
    assert info[1] == pytest.approx(0.21)
    assert sorted(info[2]) == pytest.approx(sorted(np.diag(expected_inertia(package))), rel=1e-5)
    assert (info[5], info[6]) == (pytest.approx(0.3), pytest.approx(0.0005))


def test_the_record_says_measured_with_interval_and_hashes_hold(package: Path, extended: tuple[Path, dict]):
    before, after = record(package).physics, record(extended[0]).physics
    for evidence in (after.mass_kg, after.centre_of_mass_m, after.inertia_kgm2, after.contacts[0]):
        assert evidence.source == "measured"
        assert "95 % interval" in evidence.method
    assert after.mass_kg.bounds == (0.019, 0.021)
    assert after.contacts[0].bounds is not None
    assert [c.dynamic_friction for c in after.contacts[0].bounds] == [0.19, 0.23]
    assert after.density_kgm3.source == "inferred"
    volumes = [p.mass_kg.value / p.density_kgm3.value for p in (before, after)]
    assert volumes[0] == pytest.approx(volumes[1])
    assert record(extended[0]).history[-1].name == "extend"
    for name, expected in record(extended[0]).hashes.items():
        assert file_sha256(extended[0] / name) == expected


def test_what_no_file_can_hold_is_listed_and_travels_along(extended: tuple[Path, dict]):
    folder, answer = extended
    assert {r["effect"] for r in answer["written"]} == FOUND.keys() - {"world.linear_drag"}
    (kept,) = answer["only_in_extension_json"]
    assert kept["effect"] == "world.linear_drag"
    assert kept["why"]
    assert {
        e.name for e in ModelExtension.model_validate_json((folder / "extension.json").read_bytes()).effects
    } == set(FOUND)


def test_relative_numbers_wait_for_the_body_they_are_relative_to(package: Path, tossed: Path, tmp_path: Path):
    other = ModelExtension(measurement="0" * 64)
    assert _body(package, record(package), other, None)[0] is None
    with pytest.raises(InvalidInput) as refused:
        _body(package, record(package), other, tossed)
    assert refused.value.diagnostic.code == "gap/invalid-extension"
    larger = shutil.copytree(tossed, tmp_path / "larger")
    spec = larger / "measurement.yaml"
    spec.write_text(spec.read_text().replace("size_m: [", "size_m: [1"))
    value = read(larger).value
    assert value is not None
    body, why = _body(package, record(package), ModelExtension(measurement=value.content_hash), larger)
    assert body is None
    assert "not as large" in why


def test_every_effect_with_a_place_in_urdf_is_written_and_no_other(package: Path, tmp_path: Path):
    nulls: dict[str, Values] = {e.name: {n: (v, v - 0.1, v + 0.1) for n, v in e.null().items()} for e in EFFECTS}
    given = read_extension(extension(tmp_path / "all.json", nulls, joint="door"))
    body = MeasuredBody(np.zeros(3), np.eye(3))
    rows = (*package_physics(given, b"", record(package).physics, body, "")[1], *joint_physics(given)[1])
    assert {r.effect for r in rows if r.written} == {e.name for e in EFFECTS if e.export.urdf}
    assert all(r.why for r in rows if not r.written)


def test_a_factor_is_not_applied_twice(package: Path, extended: tuple[Path, dict]):
    here = ModelExtension(measurement="0" * 64, target={"package": f"things/{package.name}"})
    assert _body(package, record(package), here, None)[0] is not None
    body, why = _body(extended[0], record(extended[0]), here, None)
    assert body is None
    assert "before" in why


def test_a_result_that_acceptance_refuses_is_not_published(package: Path, tmp_path: Path):
    before = {p: p.read_bytes() for p in package.rglob("*") if p.is_file()}
    given = extension(tmp_path / "heavy.json", {"body.mass": {"mass_kg": (9e4, 9e4, 9e4)}})
    result = RUN.invoke(app, ["gap", "extend", str(package), str(given), "--in-place", "--json"])
    assert result.exit_code == 1
    answer = json.loads(result.output)
    assert answer["path"] is None
    assert any(d["severity"] == "error" for d in answer["diagnostics"])
    assert {p: p.read_bytes() for p in package.rglob("*") if p.is_file()} == before
    assert not list(package.parent.glob(".extend*"))


@pytest.mark.parametrize(
    ("name", "values", "code"),
    [
        ("joint.magnetism", {"torque_Nm": (1.0, 1.0, 1.0)}, "gap/unknown-effect"),
        ("contact.friction", {"mu": (-0.1, -0.2, 0.0)}, "gap/invalid-extension"),
        ("contact.friction", {"friction": (0.1, 0.0, 0.2)}, "gap/invalid-extension"),
    ],
)
def test_what_is_unknown_or_impossible_is_refused(package: Path, tmp_path: Path, name: str, values: Values, code: str):
    given = extension(tmp_path / "bad.json", {name: values})
    refused = RUN.invoke(app, ["gap", "extend", str(package), str(given), "--out", str(tmp_path / "out")]).exception
    assert isinstance(refused, InvalidInput)
    assert refused.diagnostic.code == code
    assert not (tmp_path / "out").exists()


DOOR = """<robot name="d"><link name="a"/>
<link name="b"><visual><geometry><mesh filename="m/b.obj"/></geometry></visual>
<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="door" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>"""


def test_a_mechanism_gets_friction_damping_and_limits(tmp_path: Path):
    (tmp_path / "door.urdf").write_text(DOOR)
    (tmp_path / "m").mkdir()
    (tmp_path / "m" / "b.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    joint: dict[str, Values] = {
        "joint.coulomb_friction": {"torque_Nm": (0.3, 0.2, 0.4)},
        "joint.viscous_friction": {"damping_Nms_per_rad": (0.05, 0.04, 0.06)},
        "joint.hard_stop": {
            "lower_rad": (-0.5, -0.51, -0.49),
            "upper_rad": (1.2, 1.19, 1.21),
            "stiffness_Nm_per_rad": (100.0, 90.0, 110.0),
            "loss_s_per_rad": (0.1, 0.0, 0.2),
        },
        "actuator.saturation": {"limit_Nm": (4.0, 3.9, 4.1)},
        "joint.backlash": {"gap_inertia_kgm2rad": (0.01, 0.0, 0.02), "gap_rad": (0.02, 0.01, 0.03)},
    }
    given = extension(tmp_path / "found.json", joint, joint="door")
    out = tmp_path / "new"
    result = RUN.invoke(app, ["gap", "extend", str(tmp_path / "door.urdf"), str(given), "--out", str(out), "--json"])
    assert result.exit_code == 0, result.output
    assert [r["effect"] for r in json.loads(result.output)["only_in_extension_json"]] == ["joint.backlash"]
    client = pybullet.connect(pybullet.DIRECT)
    try:
        info = pybullet.getJointInfo(pybullet.loadURDF(str(out / "door.urdf"), physicsClientId=client), 0, client)
    finally:
        pybullet.disconnect(client)
    assert info[6:11] == pytest.approx((0.05, 0.3, -0.5, 1.2, 4.0))
    assert (tmp_path / "door.urdf").read_text() == DOOR
    strange = extension(tmp_path / "drawer.json", joint, joint="drawer")
    refused = RUN.invoke(app, ["gap", "extend", str(tmp_path / "door.urdf"), str(strange), "--in-place"]).exception
    assert isinstance(refused, InvalidInput)
    assert refused.diagnostic.code == "gap/unknown-place"


def test_a_folder_that_an_ingest_holds_is_left_alone(package: Path, tmp_path: Path):
    given = extension(tmp_path / "given.json", {"contact.friction": {"mu": (0.21, 0.19, 0.23)}})
    library = tmp_path / "library"
    with exclusive(library):
        with pytest.raises(FolderInUse, match=f"process {os.getpid()};"):
            extend(package, given, None, library)
        assert not (library / package.name).exists()
    assert extend(package, given, None, library).path == library / package.name
