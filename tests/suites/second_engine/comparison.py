"""One released package in PyBullet, in MuJoCo from the URDF twin and in MuJoCo from the USD: the same body and rest?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from assetkit.acceptance.stable_poses import LEAN_RAD, leaning, resting_pose
from assetkit.library.validate import main_usd_files
from assetkit.package.record import read_record
from geom.convex.support_function import diagonal
from geom.pose import matrix_of, quat_of
from schemas.arrays import FloatArray
from schemas.asset import AssetRecord
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import MassProperties, RigidBody
from sim.bullet.simulator import BulletSimulator
from sim.port import DropSettings, natural_time_s, pair_value, stillness_for, world_for
from tests.suites.second_engine import mujoco_drops
from tests.suites.second_engine.mujoco_drops import Ground
from tests.suites.second_engine.supports import is_curved, pose_classes, symmetry_axes, tilt_between
from tests.support.peers import answer_of
from usdio.reread.body import reread_body

GAP_M = 0.005
_DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class Package:
    """A released package: its record, its body as re-read from the USD, its listed poses as down directions."""

    folder: Path
    record: AssetRecord
    body: RigidBody

    @property
    def usd(self) -> Path:
        """The main USD file."""
        return main_usd_files(self.folder)[0]

    @property
    def urdf(self) -> Path:
        """The URDF twin."""
        return self.folder / "export" / f"{self.folder.name}.urdf"

    @property
    def listed_A(self) -> list[FloatArray]:
        """The direction (3,) that faces down in each stable pose of the record."""
        poses = [evidence.value for evidence in self.record.acceptance.stable_poses]
        return [-matrix_of(np.array(pose.quat_wxyz))[2] for pose in poses]


@dataclass(frozen=True)
class Rest:
    """Where a drop ended: the direction that faces down (3,), the height of the mass centre (m), whether at rest."""

    down_A: FloatArray
    centre_m: float
    still: bool


@dataclass(frozen=True)
class Pair:
    """Two engines' ends of one drop. `height_m` and `tilt_rad` are how far they are apart."""

    start: int
    curved: bool
    classes: tuple[int | None, int | None]
    height_m: float
    tilt_rad: float


def opened(folder: Path) -> Package:
    """The package in `folder`."""
    record = read_record(folder)
    assert record is not None, f"{folder} holds no record"
    return Package(folder, record, reread_body(main_usd_files(folder)[0]))


def set_down_starts(package: Package) -> list[FloatArray]:
    """X_WA (4, 4), one for each listed pose: released just above the ground, 1 % of the size and at most 5 mm."""
    gap_m = min(GAP_M, 0.01 * diagonal(package.body.shapes))
    return [resting_pose(package.body, down, gap_m=gap_m) for down in package.listed_A]


def pushed_starts(package: Package) -> list[FloatArray]:
    """X_WA (4, 4), two for each listed pose: 5 mm above the ground, leaning by 2 degrees to one or the other side."""
    downs = [leaning(down, lean) for down in package.listed_A for lean in (LEAN_RAD, -LEAN_RAD)]
    return [resting_pose(package.body, down, gap_m=GAP_M) for down in downs]


def in_bullet(package: Package, starts: Sequence[FloatArray]) -> list[Rest]:
    """Ends of the drops in our own simulator, of the body as re-read from the USD."""
    size = diagonal(package.body.shapes)
    still = stillness_for(size)
    settings = DropSettings(_duration_s(size), world_for(size), still)
    with BulletSimulator() as simulator:
        results = simulator.drop_many(package.body, starts, settings)
    return [_rest(package, r.positions_m[-1], r.quats_wxyz[-1], r.still_since_s(still) is not None) for r in results]


def in_mujoco(package: Package, starts: Sequence[FloatArray]) -> list[Rest]:
    """Ends of the drops in MuJoCo, of the body as it reads the URDF twin."""
    return _rests(package, mujoco_drops.drop_all(package.urdf, _poses(starts), ground_of(package.body)))


def ask_mujoco_usd(packages: Sequence[Package], starts: Sequence[Sequence[FloatArray]]) -> list[dict[str, Any]]:
    """Facts and drops (see `mujoco_drops.answer`) of the USD files, from MuJoCo's USD reader in its own environment."""
    request = [
        {"file": str(p.usd), "poses_WA": _poses(s), "ground": asdict(ground_of(p.body))}
        for p, s in zip(packages, starts, strict=True)
    ]
    return answer_of("mujoco-usd", mujoco_drops.__file__, request, timeout_s=300)


def in_mujoco_usd(package: Package, answer: dict[str, Any]) -> list[Rest]:
    """Ends of the drops in one answer of `ask_mujoco_usd`."""
    return _rests(package, answer["drops"])


def ground_of(body: RigidBody) -> Ground:
    """MuJoCo's ground for a body, alike to the one our own simulator uses for it."""
    size = diagonal(body.shapes)
    world, still, contact = world_for(size), stillness_for(size), body.contact
    timestep_s = min(0.002, natural_time_s(size) / 80.0)
    return Ground(
        friction=pair_value(contact.dynamic_friction, world.ground_friction, contact.combine),
        rolling_resistance_m=world.rolling_resistance_m,
        turning_loss_per_s=world.turning_loss_per_s,
        gravity_mps2=GRAVITY_MPS2,
        still_mps=still.speed_mps,
        hold_s=still.hold_s,
        duration_s=_duration_s(size),
        timestep_s=timestep_s,
        stiffness_s=2.5 * timestep_s,
    )


def pairs(package: Package, first: Sequence[Rest], second: Sequence[Rest]) -> list[Pair]:
    """The ends of each drop in two engines, compared."""
    body, ends = package.body, [rest.down_A for rest in (*first, *second)]
    axes = symmetry_axes(body)
    classes = pose_classes(body, package.listed_A, ends)
    return [
        Pair(
            start=start,
            curved=is_curved(body, a.down_A) or is_curved(body, b.down_A),
            classes=(classes[start], classes[start + len(first)]),
            height_m=abs(a.centre_m - b.centre_m),
            tilt_rad=tilt_between(axes, a.down_A, b.down_A),
        )
        for start, (a, b) in enumerate(zip(first, second, strict=True))
    ]


def mass_errors(record: AssetRecord, facts: dict[str, Any]) -> dict[str, float]:
    """Relative differences between record and engine: mass, mass centre (of the extent), principal moments, tensor."""
    physics = record.physics
    extent = float(np.linalg.norm(record.geometry.extent_m.value))
    expected, held = np.array(physics.inertia_kgm2.value), np.array(facts["inertia_kgm2"])
    return {
        "mass": abs(facts["mass_kg"] / physics.mass_kg.value - 1.0),
        "centre": float(np.abs(np.array(facts["centre_of_mass_m"]) - physics.centre_of_mass_m.value).max()) / extent,
        "moments": float(np.abs(np.linalg.eigvalsh(held) / np.linalg.eigvalsh(expected) - 1.0).max()),
        "tensor": float(np.abs(held - expected).max() / np.abs(expected).max()),
    }


def bullet_facts(urdf: Path) -> dict[str, Any]:
    """Mass, mass centre, inertia about it and friction that PyBullet reads from a URDF."""
    import pybullet

    client = pybullet.connect(pybullet.DIRECT)
    try:
        handle = pybullet.loadURDF(str(urdf), flags=pybullet.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client)
        mass, friction, moments, centre, quat_xyzw, *_ = pybullet.getDynamicsInfo(handle, -1, physicsClientId=client)
        shapes = len(pybullet.getCollisionShapeData(handle, -1, physicsClientId=client))
    finally:
        pybullet.disconnect(client)
    R = Rotation.from_quat(quat_xyzw).as_matrix()
    tensor = (R @ np.diag(moments) @ R.T).tolist()
    return {"mass_kg": mass, "centre_of_mass_m": centre, "inertia_kgm2": tensor, "friction": friction, "shapes": shapes}


def body_facts(mass: MassProperties) -> dict[str, Any]:
    """The same three of our own re-read body."""
    return {"mass_kg": mass.mass_kg, "centre_of_mass_m": mass.centre_of_mass_m, "inertia_kgm2": mass.inertia_kgm2}


def _duration_s(size: float) -> float:
    return 48.0 * natural_time_s(size)


def _poses(starts: Sequence[FloatArray]) -> list[list[float]]:
    return [[*map(float, X[:3, 3]), *map(float, quat_of(X[:3, :3]))] for X in starts]


def _rests(package: Package, drops: Sequence[dict[str, Any]]) -> list[Rest]:
    poses = [np.array(d["pose_WA"]) for d in drops]
    return [_rest(package, p[:3], p[3:], d["still"]) for p, d in zip(poses, drops, strict=True)]


def _rest(package: Package, position_m: FloatArray, quat_wxyz: FloatArray, still: bool) -> Rest:
    R_WA = matrix_of(quat_wxyz)
    centre_m = position_m[2] + R_WA[2] @ np.asarray(package.body.mass.centre_of_mass_m)
    return Rest(-R_WA[2], float(centre_m), still)
