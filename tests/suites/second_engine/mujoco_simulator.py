"""The simulator of suites in MuJoCo: drops and grasps of rigid bodies (`sim.port.Simulator`), built from their shapes.

Contacts are springs in MuJoCo: a grasp creeps and a body sinks in by `0.1 g stiffness^2`. Everything has its true size.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from formats.urdf.write import write_urdf
from geom import pose
from geom.convex.support_function import heights
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from schemas.physics import CollisionShape, RigidBody
from sim.grasp_run import run_grasp
from sim.grasp_trial import GraspOutcome, GraspTask
from sim.gripper_description import HAND, LEFT, LINK_KG, RIGHT, describe_gripper, mount_joints
from sim.port import DropResult, DropSettings, pair_value, rms_speeds

STEP_S = 0.0005  # in place of 1/240 s: MuJoCo's contacts need finer steps than those that suites ask for
STIFFNESS_S = 4.0 * STEP_S  # time constant of the contact spring
HAND_FORCE_FACTOR = 100.0
# Levers of torsional and rolling friction, MuJoCo's defaults: a pad touches in a patch, not at points.
PATCH_FRICTION_M = (0.005, 0.0001)
_KINDS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "hull": mujoco.mjtGeom.mjGEOM_MESH,
}
TOUCH_S = 0.02
BODY = "subject"


class MujocoSimulator:
    """Drops and grasps; the steps of settings and tasks are replaced by `STEP_S`, their ratio to 1/240 s is kept."""

    @property
    def name(self) -> str:
        """Engine and version."""
        return f"mujoco {mujoco.__version__}"

    def __enter__(self) -> MujocoSimulator:
        return self

    def __exit__(self, *exception: object) -> None:
        """Nothing to free."""

    def drop(self, body: RigidBody, X_WA: FloatArray, settings: DropSettings) -> DropResult:
        """See `sim.port.Simulator`."""
        world = settings.world
        friction = pair_value(body.contact.dynamic_friction, world.ground_friction, body.contact.combine)
        spec = mujoco.MjSpec()
        _set_world(spec, world.gravity_mps2, STEP_S * world.timestep_s * 240.0)
        _add_body(spec, body, [friction, 1e-5, max(world.rolling_resistance_m, 1e-6)])
        model = spec.compile()
        data = mujoco.MjData(model)
        _place(model, data, X_WA)
        still = settings.still
        rows, quiet_s = [_row(model, data)], 0.0
        kept = math.exp(-world.turning_loss_per_s * model.opt.timestep)
        while data.time < settings.duration_s:
            mujoco.mj_step(model, data)
            data.qvel[3:6] *= kept
            rows.append(_row(model, data))
            if not np.isfinite(rows[-1][0]).all() or abs(rows[-1][0][:3]).max() > 1e3:
                rows.pop()
                return _result(body, rows, settings, model, data, finite=False)
            if still is not None:
                quiet = _speeds(body, rows[-1:])[0] <= still.speed_mps
                quiet_s = quiet_s + model.opt.timestep if quiet else 0.0
                if quiet_s > still.hold_s:
                    break
        return _result(body, rows, settings, model, data, finite=True)

    def drop_many(
        self, body: RigidBody, poses_WA: Sequence[FloatArray], settings: DropSettings
    ) -> tuple[DropResult, ...]:
        """See `sim.port.Simulator`."""
        return tuple(self.drop(body, X_WA, settings) for X_WA in poses_WA)

    def grasp(self, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> GraspOutcome:
        """See `sim.port.Simulator`."""
        return run_grasp(_MujocoGraspWorld(body, X_WA, task), body, X_WA, task)


@dataclass(frozen=True)
class _Handles:
    body: int
    ground: int
    left: int
    right: int
    hand: int
    mount: list[int]  # addresses of the positions of the mount
    actuators: dict[str, int]


class _MujocoGraspWorld:
    """See `sim.grasp_run.GraspWorld`."""

    def __init__(self, body: RigidBody, X_WA: FloatArray, task: GraspTask) -> None:
        self._task, self._touched = task, dict[int, float]()
        X_WG = X_WA @ task.X_AG
        turns = task.motion.turns_wrist
        self._mount = mount_joints(turns)
        gripper = describe_gripper(task.gripper, task.opening_m, X_WG[:3, :3], turns_wrist=turns)
        urdf = write_urdf(gripper).data.decode()
        spec = mujoco.MjSpec.from_string(urdf)  # Its mimic joint becomes an equality.
        spec.compiler.fusestatic = False
        for geom in spec.geoms:
            geom.contype, geom.conaffinity = (2, 1) if geom.contype else (0, 0)
        for equality in spec.equalities:
            equality.solref = [2.0 * STEP_S, 1.0]
            equality.solimp = [0.99, 0.999, 1e-4, 0.5, 2.0]
        spec.worldbody.first_body().pos = X_WG[:3, 3].tolist()
        _set_world(spec, (0.0, 0.0, -GRAVITY_MPS2), STEP_S * task.step_s * 240.0)
        # Body against the pads with the friction of the task, against the ground half of it, as in the other engine.
        _add_body(spec, body, [task.friction, *PATCH_FRICTION_M])
        self._strong = HAND_FORCE_FACTOR * (body.mass.mass_kg + (6.0 + turns) * LINK_KG) * GRAVITY_MPS2
        for name in self._mount:
            _motor(spec, name, kp=4e4, kv=1.2e3, force_n=self._strong)
        for name in (LEFT, RIGHT):
            motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            motor.set_to_velocity(kv=2e3)
            motor.forcerange = [-task.force_n, task.force_n]
        self._model = model = spec.compile()
        self._data = mujoco.MjData(model)
        for name in (LEFT, RIGHT, *self._mount):  # The limit of the finger's motor is the task's, not the URDF's.
            joint = model.joint(name)
            model.jnt_actfrclimited[joint.id] = False
        names = model.geom
        self._handles = _Handles(
            model.body(BODY).id,
            names("ground").id,
            model.body(LEFT).id,
            model.body(RIGHT).id,
            model.body(HAND).id,
            [int(model.joint(name).qposadr[0]) for name in self._mount],
            {name: model.actuator(name).id for name in (*self._mount, LEFT, RIGHT)},
        )
        _place(model, self._data, X_WA)
        mujoco.mj_forward(model, self._data)

    @property
    def time_s(self) -> float:
        return float(self._data.time)

    def place_mount(self, positions: FloatArray) -> None:
        for address, position in zip(self._handles.mount, positions.tolist(), strict=False):
            self._data.qpos[address] = position
        mujoco.mj_forward(self._model, self._data)

    def drive_mount(self, positions: FloatArray, rates: FloatArray) -> None:
        # A position servo damps against standing still: its target runs ahead by what the rate is worth.
        for name, position, rate in zip(self._mount, positions.tolist(), rates.tolist(), strict=False):
            self._data.ctrl[self._handles.actuators[name]] = position + rate * 1.2e3 / 4e4

    def drive_fingers(self, closing: float) -> None:
        force = self._task.force_n + self._strong * (closing <= 0.0)
        for name in (LEFT, RIGHT):
            actuator = self._handles.actuators[name]
            self._data.ctrl[actuator] = closing * self._task.gripper.speed_mps
            self._model.actuator_forcerange[actuator] = [-force, force]

    def step(self) -> None:
        mujoco.mj_step(self._model, self._data)
        self._touched |= dict.fromkeys(self._bodies_on_subject(), self.time_s)

    def body_pose(self) -> FloatArray:
        body = self._handles.body
        return pose.pose_from_quat(self._data.xquat[body].copy(), self._data.xpos[body].copy())

    def body_velocity(self) -> tuple[FloatArray, FloatArray]:
        row = _row(self._model, self._data)
        return _centre_velocity(self._model.body_ipos[self._handles.body], row)

    def gripper_poses(self) -> FloatArray:
        handles = self._handles
        return np.stack(
            [pose.pose_from_quat(self._data.xquat[b].copy(), self._data.xpos[b].copy())
             for b in (handles.left, handles.right, handles.hand)]
        )  # fmt: skip

    def finger_touches(self) -> tuple[bool, bool]:
        return self._touches(self._handles.left), self._touches(self._handles.right)

    def hand_touches(self) -> bool:
        return any(self._touches(body) for body in (self._handles.left, self._handles.right, self._handles.hand))

    def is_supported(self) -> bool:
        return self._touches(0)

    def _touches(self, body: int) -> bool:
        """Whether it touched the subject a moment ago: stiff contacts come and go from step to step."""
        return self._touched.get(body, -math.inf) >= self.time_s - TOUCH_S

    def _bodies_on_subject(self) -> Iterator[int]:
        for contact in self._data.contact:
            pair = [int(self._model.geom_bodyid[g]) for g in contact.geom]
            if self._handles.body in pair and contact.dist <= 1e-4:
                yield pair[1 - pair.index(self._handles.body)]


def _set_world(spec: mujoco.MjSpec, gravity_mps2: Sequence[float], step_s: float) -> None:
    spec.option.gravity = list(gravity_mps2)
    spec.option.timestep = step_s
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0])


def _motor(spec: mujoco.MjSpec, joint: str, *, kp: float, kv: float, force_n: float) -> None:
    motor = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.set_to_position(kp=kp, kv=kv)
    motor.forcerange = [-force_n, force_n]


def _add_body(spec: mujoco.MjSpec, body: RigidBody, friction: Sequence[float]) -> None:
    """The body with a free joint, its shapes and its mass; its friction holds for every pair."""
    inertia = np.asarray(body.mass.inertia_kgm2)
    free = spec.worldbody.add_body(name=BODY, explicitinertial=True)
    free.mass = body.mass.mass_kg
    free.ipos = np.asarray(body.mass.centre_of_mass_m).tolist()
    free.fullinertia = [*np.diag(inertia).tolist(), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    free.add_freejoint()
    for number, shape in enumerate(body.shapes):
        _add_shape(spec, free, shape, number, friction)


def _add_shape(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, shape: CollisionShape, number: int, friction: Sequence[float]
) -> None:
    geom = body.add_geom(type=_KINDS[shape.kind])
    if shape.kind == "hull":
        assert shape.points is not None
        name = f"hull_{number}"
        spec.add_mesh(
            name=name, uservert=shape.points.ravel().tolist(), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        )
        geom.meshname = name
    else:
        geom.size = _size(shape)
        geom.pos = shape.X_AS[:3, 3].tolist()
        geom.quat = pose.quat_of(shape.X_AS[:3, :3]).tolist()
    geom.priority, geom.condim, geom.friction = 1, 6, list(friction)
    geom.solref = [STIFFNESS_S, 1.0]


def _size(shape: CollisionShape) -> list[float]:
    if shape.kind == "box":
        return [0.5 * edge for edge in shape.size_m]
    if shape.kind == "sphere":
        return [shape.size_m[0], 0.0, 0.0]
    return [shape.size_m[0], 0.5 * shape.size_m[1], 0.0]


def _place(model: mujoco.MjModel, data: mujoco.MjData, X_WA: FloatArray) -> None:
    first = int(model.body(BODY).jntadr[0])
    address = int(model.jnt_qposadr[first])
    data.qpos[address : address + 3] = X_WA[:3, 3]
    data.qpos[address + 3 : address + 7] = pose.quat_of(X_WA[:3, :3])


def _row(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[FloatArray, FloatArray]:
    """Position and quaternion (7,), velocity of the origin in world axes and turning rate in body axes (6,)."""
    first = int(model.body(BODY).jntadr[0])
    q, v = int(model.jnt_qposadr[first]), int(model.jnt_dofadr[first])
    return data.qpos[q : q + 7].copy(), data.qvel[v : v + 6].copy()


def _centre_velocity(centre_A: FloatArray, row: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Velocity of the mass centre and turning rate in world axes; MuJoCo's are of the origin, and in body axes."""
    position, velocity = row
    R_WA = pose.matrix_of(position[3:7])
    return velocity[:3] + R_WA @ np.cross(velocity[3:6], centre_A), R_WA @ velocity[3:6]


def _speeds(body: RigidBody, rows: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
    centre = np.asarray(body.mass.centre_of_mass_m)
    moving = [_centre_velocity(centre, row) for row in rows]
    R_WA = np.stack([pose.matrix_of(position[3:7]) for position, _ in rows])
    return rms_speeds(body.mass, R_WA, np.stack([v for v, _ in moving]), np.stack([w for _, w in moving]))


def _result(
    body: RigidBody,
    rows: Sequence[tuple[FloatArray, FloatArray]],
    settings: DropSettings,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    *,
    finite: bool,
) -> DropResult:
    positions = np.stack([position for position, _ in rows])
    centre = np.asarray(body.mass.centre_of_mass_m)
    moving = [_centre_velocity(centre, row) for row in rows]
    R_WA = np.stack([pose.matrix_of(position[3:7]) for position in positions])
    return DropResult(
        times_s=np.arange(len(rows)) * model.opt.timestep,
        positions_m=positions[:, :3],
        quats_wxyz=positions[:, 3:],
        linear_mps=np.stack([v for v, _ in moving]),
        angular_radps=np.stack([w for _, w in moving]),
        speeds_mps=_speeds(body, rows),
        heights_m=heights(body.shapes, positions[:, :3], R_WA),
        contacts=int(data.ncon),
        left_patch=bool(np.linalg.norm(positions[:, :2] - positions[0, :2], axis=1).max() > settings.patch_radius_m),
        finite=finite,
    )
