"""Variants as stages: every stamp and pose is read back bit for bit, outside judges and the gate pass them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade

from gate.external_validators import usd_validation
from gate.static_gate import gate
from replay.recording.formats.read import read_episode
from replay.recording.formats.write import write_variant
from replay.variant_stage import compose, timed_bodies
from schemas.diagnostics import InvalidInput, Severity
from schemas.replay.documents import Inserted, Variant
from schemas.scene.program import BoxAsset, PairedMaterial
from tests.conftest import SHARED
from tests.support import replay_samples

STEEL = PairedMaterial(id="steel", objects=("box",), base_color=(0.6, 0.1, 0.1), static_friction=0.4)
BOX = Inserted(
    name="inserted_00_box",
    asset_id="box",
    position_m=(0.6, 0.3, 0.22),
    quat_wxyz=(1.0, 0.0, 0.0, 0.0),
    support="top",
    primitive=BoxAsset(type="box", size_m=(0.05, 0.08, 0.12)),
    material="steel",
)
LIGHTS: dict[str, float | str] = {"id": "warm", "intensity": 1500.0, "temperature_K": 4000.0}


def variant_in(folder: Path, source: Path, *inserted: Inserted) -> Path:
    variant = Variant(
        episode="one",
        source=str(source),
        seed=1,
        number=0,
        clearance_m=0.01,
        objects_requested=1,
        inserted=inserted,
        materials={"steel": STEEL},
        lights=LIGHTS,
    )
    write_variant(read_episode(source), variant, folder)
    return folder


@pytest.fixture(scope="module")
def composed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("variant")
    return compose(variant_in(place / "0", replay_samples.staged(place / "source"), BOX), None)


def samples(stage: Usd.Stage) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Time codes (k,) and X_WB (k, 4, 4) of everything recorded, by name."""
    motion = {}
    for prim in stage.Traverse():
        xformable = UsdGeom.Xformable(prim)
        name = prim.GetCustomDataByKey("mana:id")
        if name and not str(prim.GetPath()).startswith("/World/Inserted"):
            (op,) = xformable.GetOrderedXformOps()
            times = op.GetAttr().GetTimeSamples()
            values = [op.Get(t) for t in times] or [op.Get()]
            motion[name] = (np.array(times), np.array([np.array(v) for v in values]).transpose(0, 2, 1))
    return motion


def assert_same_motion(file: Path, source: Path) -> None:
    episode = read_episode(source)
    last = np.flatnonzero(np.append(np.diff(episode.t_s) > 0.0, True))
    read = samples(Usd.Stage.Open(str(file)))
    recorded = {body.name: body.X_WB for body in timed_bodies(episode)} | {c.name: c.X_WC for c in episode.cameras}
    assert sorted(read) == sorted(recorded)
    for name, X_W in recorded.items():
        times, poses = read[name]
        if len(times):
            assert times.tobytes() == episode.t_s[last].tobytes(), name
            np.testing.assert_array_equal(poses, X_W[last], err_msg=name)
        else:
            np.testing.assert_array_equal(X_W, np.broadcast_to(poses, X_W.shape), err_msg=name)


def test_stamps_and_poses_are_read_back_bit_for_bit(composed: Path):
    assert_same_motion(composed, composed.parents[1] / "source")
    stage = Usd.Stage.Open(str(composed))
    t_s = replay_samples.stamps()
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (t_s[0], t_s[-1])
    assert stage.GetTimeCodesPerSecond() == 1.0
    assert list(stage.GetRootLayer().customLayerData["mana:rowsBehindTheSameStamp"]) == [4]


@pytest.mark.shared
def test_a_real_recording_is_read_back_bit_for_bit(tmp_path: Path):
    source = SHARED / "episodes" / "panda_lift"
    if not source.is_dir():
        pytest.skip("the shared data folder is not beside the repository")
    assert_same_motion(compose(variant_in(tmp_path / "0", source, BOX), None), source)


def test_judges_pass(composed: Path):
    for name in ("replay.usda", "context.usda"):
        verdict = usd_validation(composed.parent / name)
        assert verdict.passed, verdict.findings
        assert not verdict.warnings
        assert [d for d in gate(composed.parent / name) if d.severity is Severity.ERROR] == []


def test_what_moves_is_kinematic_and_what_was_put_in_stands_in_its_material(composed: Path):
    stage = Usd.Stage.Open(str(composed))
    cube = UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath("/World/Objects/cube"))
    assert cube.GetKinematicEnabledAttr().Get()
    box = stage.GetPrimAtPath("/World/Inserted/inserted_00_box")
    assert not box.HasAPI(UsdPhysics.RigidBodyAPI)
    shape = UsdShade.MaterialBindingAPI(box.GetChild("Shape"))
    assert shape.ComputeBoundMaterial()[0].GetPath().name == "steel_inserted_00_box"
    physics = UsdPhysics.MaterialAPI(shape.ComputeBoundMaterial("physics")[0])
    assert physics.GetStaticFrictionAttr().Get() == pytest.approx(0.4)
    lamp = UsdLux.LightAPI(stage.GetPrimAtPath("/World/Lights/Lamp"))
    assert lamp.GetIntensityAttr().Get() == 1500.0


def test_cameras_have_the_recorded_field_of_view(composed: Path):
    stage = Usd.Stage.Open(str(composed))  # Prims live as long as it does.
    cameras = read_episode(composed.parents[1] / "source").cameras
    assert cameras
    for camera in cameras:
        lens = UsdGeom.Camera(stage.GetPrimAtPath(f"/World/Cameras/{camera.name}")).GetCamera(0.0)
        assert np.radians(lens.GetFieldOfView(lens.FOVVertical)) == pytest.approx(camera.fovy_rad, abs=1e-6)
        assert lens.aspectRatio == pytest.approx(camera.width_px / camera.height_px)


def test_same_variant_same_bytes(composed: Path):
    before = {name: (composed.parent / name).read_bytes() for name in ("replay.usda", "context.usda", "motion.usdc")}
    compose(composed.parent, None)
    assert before == {name: (composed.parent / name).read_bytes() for name in before}


@pytest.mark.parametrize(("package", "code"), [("mug", "replay/missing-file"), ("../mug", "replay/path-escape")])
def test_a_package_that_is_not_there_is_said(tmp_path: Path, package: str, code: str):
    source = replay_samples.staged(tmp_path / "source")
    missing = BOX.model_copy(update={"package": package, "primitive": None})
    with pytest.raises(InvalidInput) as refused:
        compose(variant_in(tmp_path / "0", source, missing), None)
    assert refused.value.diagnostic.code == code
