"""What a draw promises: the same numbers whatever the batch, poses inside their cells, shares as the plan has them."""

import hashlib
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import runtime_plan
from runtime_plan import Plan, Samples, prepare, sample
from runtime_plan.counter_rng import uniforms
from schemas.scene.runtime_plan import RuntimePlan
from tests.support.plan.library import grid_plan, round_body, tray_plan

GRID, TRAY = prepare(grid_plan(12, 40)), prepare(tray_plan())
ARRAYS = [f.name for f in fields(Samples) if f.name not in ("seed", "start", "names")]


def same(one: Samples, two: Samples, rows: slice) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(one, name)[rows], getattr(two, name), err_msg=name)


def test_public_names_are_sorted_and_there():
    assert list(runtime_plan.__all__) == sorted(runtime_plan.__all__)
    assert all(hasattr(runtime_plan, name) for name in runtime_plan.__all__)


@pytest.mark.parametrize("plan", [GRID, TRAY], ids=["grid", "tray"])
@given(seed=st.integers(0, 2**64 - 1), start=st.integers(0, 2**40), cut=st.integers(0, 1300))
def test_any_split_gives_the_same_samples(plan: Plan, seed: int, start: int, cut: int):
    whole = sample(plan, 1300, seed, start)
    same(whole, sample(plan, cut, seed, start), slice(0, cut))
    same(whole, sample(plan, 1300 - cut, seed, start + cut), slice(cut, 1300))


def test_another_seed_gives_other_samples():
    assert not np.array_equal(sample(GRID, 5, 0).position_m, sample(GRID, 5, 1).position_m)


def test_words_of_a_sample_do_not_overlap_those_of_the_next():
    one, two = uniforms(3, 10, 2, 5), uniforms(3, 11, 1, 5)
    np.testing.assert_array_equal(one[1], two[0])
    assert len(np.unique(one)) == one.size


def outlines(plan: RuntimePlan, body: int, stance: int, quat_wxyz: np.ndarray) -> np.ndarray:
    """Outlines (n, v, 2) about the asset origin, by matrices instead of half angles."""
    form = plan.bodies[body].stances[stance]
    turn = (
        Rotation.from_quat(quat_wxyz, scalar_first=True) * Rotation.from_quat(form.quat_wxyz, scalar_first=True).inv()
    )
    points = np.array([(*p, 0.0) for prism in form.prisms for p in prism.outline_m])
    return np.einsum("nij,vj->nvi", turn.as_matrix(), points)[..., :2]


def test_every_footprint_lies_in_its_cell_at_a_yaw_of_its_intervals():
    drawn, plan = sample(GRID, 3000, 11), GRID.document
    (pool,) = plan.combinations[0].pools
    cells = np.array([case.cells_um for case in pool.cases])[drawn.case[:, 0]] * 1e-6
    for k in range(12):
        outline = outlines(plan, k, 0, drawn.quat_wxyz[:, k]) + drawn.position_m[:, k, None, :2]
        low, high = outline.min(axis=1), outline.max(axis=1)
        assert (low >= cells[:, k, [0, 2]] - 1e-9).all()
        assert (high <= cells[:, k, [1, 3]] + 1e-9).all()
        yaws = [pool.cases[c].yaws_urad[k] for c in drawn.case[:, 0]]
        inside = [any(a <= 1e6 * y <= b for a, b in turns) for y, turns in zip(drawn.yaw_rad[:, k], yaws, strict=True)]
        assert all(inside)
    np.testing.assert_allclose(drawn.position_m[..., 2], 0.7)


def test_a_draw_reaches_both_ends_of_its_freedom():
    """A coin in a cell: its middle is uniform over the cell less its radius."""
    plan = prepare(grid_plan(1, 1, bodies=(round_body("coin", 0.1, 64),)))
    low, high = (1e-6 * end for end in plan.document.combinations[0].pools[0].cases[0].cells_um[0][:2])
    drawn = sample(plan, 20_000, 5).position_m[:, 0, 0]
    assert drawn.min() == pytest.approx(low + 0.1, abs=1e-3)
    assert drawn.max() == pytest.approx(high - 0.1, abs=1e-3)
    assert drawn.std() == pytest.approx((high - low - 0.2) / 12**0.5, rel=0.02)


def test_things_on_a_movable_owner_move_with_it():
    drawn = sample(TRAY, 2000, 1)
    tray, cup, block = (drawn.names.index(name) for name in ("tray", "cup", "block"))
    tray_R_W = Rotation.from_quat(drawn.quat_wxyz[:, tray], scalar_first=True).inv()
    for child, height in ((cup, 0.02), (block, 0.02)):
        at = tray_R_W.apply(drawn.position_m[:, child] - drawn.position_m[:, tray])
        assert (np.abs(at[:, :2]) <= np.array([0.2, 0.15])).all()
        lying = drawn.stance[:, child] == 1
        np.testing.assert_allclose(at[~lying, 2], height, atol=1e-12)
        np.testing.assert_allclose(at[lying, 2], height + 0.025, atol=1e-12)
    turned = (tray_R_W * Rotation.from_quat(drawn.quat_wxyz[:, cup], scalar_first=True)).as_rotvec()[:, 2]
    np.testing.assert_allclose(np.cos(turned), np.cos(drawn.yaw_rad[:, cup]), atol=1e-9)
    assert set(drawn.support[:, cup]) == {tray}


def test_a_pinned_pose_is_where_it_is_pinned():
    drawn = sample(TRAY, 500, 2)
    plate = drawn.names.index("plate")
    has = drawn.present[:, plate]
    c, s = np.cos(0.5), np.sin(0.5)
    at = (drawn.position_m[has, plate, :2] - (0.3, -0.2)) @ np.array([[c, -s], [s, c]])
    np.testing.assert_allclose(at[:, 0], 0.25, atol=1e-12)
    assert at[:, 1].min() >= -0.009 - 1e-12
    assert at[:, 1].max() <= 0.09 + 1e-12


def test_shares_are_those_of_the_plan():
    drawn = sample(TRAY, 30_000, 4)
    names = drawn.names
    assert (drawn.combination == 0).mean() == pytest.approx(2 / 3, abs=0.01)
    assert (drawn.present[:, names.index("plate")] == (drawn.combination == 0)).all()
    assert (drawn.stance[:, names.index("block")] == 0).mean() == pytest.approx(0.75, abs=0.01)
    assert (drawn.asset_index[:, names.index("cup")] == 2).mean() == pytest.approx(0.5, abs=0.01)
    first = drawn.combination == 0
    np.testing.assert_allclose(
        [(drawn.material[first, names.index("tray")] == m).mean() for m in (-1, 0, 1)], 1 / 3, atol=0.02
    )
    assert ((drawn.material[:, names.index("block")] == 1) == (drawn.material[:, names.index("tray")] == 1)).all()
    assert (drawn.background_material[first] == 2).mean() == pytest.approx(0.5, abs=0.02)
    assert (drawn.background_material[~first] == -1).all()
    assert (drawn.lighting[~first] == 1).all()


def test_channels_stay_in_their_bounds_and_others_are_left_alone():
    drawn = sample(TRAY, 5000, 8)
    noon, dusk = drawn.channels[drawn.lighting == 0], drawn.channels[drawn.lighting == 1]
    assert np.isnan(noon[:, [1, 3]]).all()
    assert np.isnan(dusk[:, 2]).all()
    assert ((noon[:, 0] >= 800) & (noon[:, 0] < 1200)).all()
    assert ((dusk[:, 1] >= 0) & (dusk[:, 1] < 1)).all()


BARE = """
import sys
class Refuse:
    def find_spec(self, name, path=None, target=None):
        top = name.split(".")[0]
        if top not in sys.stdlib_module_names | {known} and not top.startswith("_"):
            raise ImportError(f"{name} is not there")
sys.meta_path.insert(0, Refuse())
import runtime_plan
plan = runtime_plan.load(sys.argv[1])
drawn = runtime_plan.sample(plan, 3, 0)
print(drawn.position_m.tobytes().hex())
"""
KNOWN = (
    '{"numpy", "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection", '
    '"schemas", "runtime_plan"}'
)


def test_a_draw_needs_numpy_pydantic_and_schemas_alone(tmp_path: Path):
    path = tmp_path / "plan.json"
    path.write_text(tray_plan().model_dump_json())
    run = subprocess.run(
        [sys.executable, "-c", BARE.replace("{known}", KNOWN), str(path)], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert bytes.fromhex(run.stdout) == sample(TRAY, 3, 0).position_m.tobytes()


# The bits of one sample as drawn where this test was written; another machine must find the same.
RECORDED = "dd9cae57734bf17a5d5a53fe30b727910f38862a1c7d51c3b71ceaaea4b5712a"


def test_the_same_bits_on_every_machine():
    drawn = sample(TRAY, 256, 2026)
    digest = hashlib.sha256()
    for name in ("case", "asset_index", "position_m", "quat_wxyz", "material", "channels"):
        digest.update(np.ascontiguousarray(getattr(drawn, name)).tobytes())
    assert digest.hexdigest() == RECORDED
