"""Tumbling boxes: energy, closed forms of one impact, sliding and rest, and the same tosses in MuJoCo."""

from __future__ import annotations

import io
import json

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.suites.gap2.generate.bodies import GRAVITY, Box, HiddenInBox, move
from tests.suites.gap2.generate.power import LEVELS
from tests.suites.gap2.generate.tosses.cases import tumble_case
from tests.suites.gap2.generate.tumbling import box_corners

BOX = Box(np.array([0.11, 0.08, 0.095]), 0.7, 0.3, slides=False, tumbles=True)
T_S = np.linspace(0.0, 0.8, 401)


def thrown(seed: int) -> np.ndarray:
    """(13,) a box above the board that falls, drifts and turns."""
    rng = np.random.default_rng(seed)
    quat = np.roll(Rotation.random(rng=rng).as_quat(), 1)
    return np.array([0.0, 0.0, 0.12, *quat, *rng.uniform(-0.8, 0.8, 2), -0.5, *rng.normal(0.0, 4.0, 3)])


def energy(box: Box, out: np.ndarray) -> np.ndarray:
    """(rows,) J."""
    moving = 0.5 * box.mass_kg * (out[:, 7:10] ** 2).sum(axis=1)
    return moving + 0.5 * out[:, 10:] ** 2 @ box.inertia_kgm2 + box.mass_kg * GRAVITY * out[:, 2]


def depths(box: Box, out: np.ndarray) -> np.ndarray:
    """(rows,) m, by which the lowest corner is below the board."""
    R = Rotation.from_quat(np.roll(out[:, 3:7], -1, axis=1)).as_matrix()
    return -(out[:, 2] + (R[:, 2] @ box_corners(box.size_m).T).min(axis=1))


@pytest.mark.parametrize("seed", range(6))
def test_contact_takes_energy_and_never_gives_any(seed: int) -> None:
    out = move(BOX, HiddenInBox(), T_S[None], thrown(seed)[None])[0]
    joules = energy(BOX, out)
    scale = BOX.mass_kg * GRAVITY * 0.1
    assert np.diff(joules).max() < 2e-3 * scale
    assert joules[-1] < joules[0] - 0.2 * scale
    assert depths(BOX, out).max() < 1e-3 * 0.1
    until = int(np.argmax(depths(BOX, out) > -1e-3))
    assert np.ptp(joules[: max(until - 2, 2)]) < 1e-8 * joules[0]


def test_a_blow_on_one_corner_without_friction_has_its_closed_form() -> None:
    """The corner's normal velocity is stopped; nothing else of the body's momentum changes."""
    slippery = Box(BOX.size_m, BOX.mass_kg, 0.0, slides=False, tumbles=True)
    turn = Rotation.from_rotvec([0.5, 0.4, 0.1])
    corners = turn.apply(box_corners(BOX.size_m))
    lowest = corners[np.argmin(corners[:, 2])]
    v, w_B = np.array([0.3, -0.2, -1.0]), np.array([1.0, 2.0, -0.5])
    start = np.array([[0.0, 0.0, 1e-6 - lowest[2], *np.roll(turn.as_quat(), 1), *v, *w_B]])
    out = move(slippery, HiddenInBox(gravity=1e-9), np.array([[0.0, 1e-3]]), start)[0, 1]
    R = turn.as_matrix()
    inverse = R @ np.diag(BOX.mass_kg / BOX.inertia_kgm2) @ R.T
    w = R @ w_B
    turned = np.cross(lowest, [0.0, 0.0, 1.0])
    j = -(v + np.cross(w, lowest))[2] / (1.0 + turned @ inverse @ turned)
    assert out[7:10] == pytest.approx([v[0], v[1], v[2] + j], abs=5e-3)
    expected_w = w + inverse @ turned * j
    after = Rotation.from_quat(np.roll(out[3:7], -1)).apply(out[10:])
    assert after == pytest.approx(expected_w, abs=0.05)


def test_a_flat_box_slides_as_far_as_friction_says_and_rests() -> None:
    start = np.array([[0.0, 0.0, 0.5 * BOX.size_m[2], 1.0, 0.0, 0.0, 0.0, 0.9, 0.3, 0.0, 0.0, 0.0, 0.0]])
    out = move(BOX, HiddenInBox(), T_S[None], start)[0]
    assert np.linalg.norm(out[-1, :2]) == pytest.approx(0.9 / (2.0 * 0.3 * GRAVITY), rel=0.02)
    assert np.abs(out[-50:, 7:]).max() < 1e-3
    assert out[-1, 2] == pytest.approx(0.5 * BOX.size_m[2], abs=1e-5)


def in_mujoco(box: Box, start: np.ndarray, step_s: float = 2e-5) -> np.ndarray:
    """(rows, 7) poses at T_S with contacts as stiff as the step allows."""
    x, y, z = 0.5 * box.size_m
    inertia = " ".join(f"{v:.12g}" for v in box.inertia_kgm2)
    contact = f'friction="{box.mu} 0 0" solref="{8 * step_s} 1" solimp="0.99 0.999 1e-5"'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step_s}" cone="elliptic" impratio="30" gravity="0 0 {-GRAVITY}"/><worldbody>'
        f'<geom type="plane" size="9 9 1" condim="3" {contact}/><body><freejoint/>'
        f'<inertial pos="0 0 0" mass="{box.mass_kg}" diaginertia="{inertia}"/>'
        f'<geom type="box" size="{x} {y} {z}" condim="3" {contact}/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start[:7], start[7:]
    poses = []
    for stamp in T_S:
        while data.time < stamp - 0.5 * step_s:
            mujoco.mj_step(model, data)
        poses.append(data.qpos.copy())
    return np.array(poses)


@pytest.mark.long
def test_mujoco_moves_the_same_boxes_alike_through_their_impacts() -> None:
    """Where both are in contact for 60 ms, they differ by a tenth of the way that contact changed, in the median."""
    shares = []
    for seed in range(12):
        start = thrown(seed)
        ours = move(BOX, HiddenInBox(), T_S[None], start[None])[0]
        free = move(Box(BOX.size_m, BOX.mass_kg, BOX.mu, slides=False), HiddenInBox(), T_S[None], start[None])[0]
        touched = int(np.argmax(depths(BOX, ours) > -1e-4))
        end = touched + 30
        theirs = in_mujoco(BOX, start)[end]
        changed = np.linalg.norm(ours[end, :3] - free[end, :3])
        shares.append(np.linalg.norm(ours[end, :3] - theirs[:3]) / changed)
    assert np.median(shares) < 0.1
    assert np.quantile(shares, 0.9) < 0.3


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 6, 10])
def test_tumbling_cases_are_reproducible_touch_the_board_and_have_their_level(number: int) -> None:
    case = tumble_case(number)
    assert case == tumble_case(number)
    assert case.truth.scene == "tumble"
    spec = json.loads(case.files["measurement.yaml"])
    assert spec["world"]["support"]["plane"]["height_m"] == 0.0
    tables = [np.genfromtxt(io.BytesIO(v), delimiter=",", names=True) for k, v in case.files.items() if "traj" in k]
    longest = max(spec["subject"]["box"]["size_m"])
    assert all(table["pz"].min() < 0.75 * longest for table in tables)
    if case.truth.effects:
        assert case.truth.level_reached == (case.truth.miss > 0.9 * LEVELS[case.truth.level])
    else:
        assert case.truth.family == "control"
