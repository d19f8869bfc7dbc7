"""Roll-outs of a free body with joints in PyBullet (`LinkageRollout`); `sim.bullet.simulator` lists the engine's traps.

Windows, steps, support and contacts are those of `sim.bullet.body`; here the body is one of the engine's multi-bodies
(reduced coordinates), whose joints are free unless laws act on them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.mass.principal_axes import principal_axes
from schemas.arrays import FloatArray
from schemas.physics import CollisionShape
from sim.bullet.shapes import PARKED_M, clear_margins, compound
from sim.bullet.windows import (
    HOLD_S,
    WindowsClient,
    contact_parameters,
    empty_world,
    hold_last_valid,
    measured_motion,
    start_states,
    steps_for,
)
from sim.dynamics.body_rollout import BodyMotion
from sim.dynamics.hooks import (
    BodyState,
    BodyWrench,
    JointFriction,
    JointState,
    JointTorque,
    Params,
    StepHook,
    fresh_memory,
    step_value,
)
from sim.dynamics.linkage_rollout import LinkageModel, LinkageMotion, LinkageWindows
from sim.dynamics.mechanism import LARGEST_RATE, Law

_STATE = 13  # columns of the base before those of the joints


class BulletLinkageRollout(WindowsClient):
    """One private DIRECT client; close it, or use it as a context manager."""

    _loaded: tuple[LinkageModel, float] | None = None

    def rollout(
        self,
        model: LinkageModel,
        windows: LinkageWindows,
        wrenches: Sequence[tuple[BodyWrench, Params]] = (),
        laws: Sequence[Law] = (),
        finer: float = 1.0,
    ) -> LinkageMotion:
        """See `sim.dynamics.linkage_rollout.LinkageRollout`."""
        if self._loaded is None or model is not self._loaded[0] or finer != self._loaded[1]:
            self._largest_step_s = self._usual_step_s / finer
            self._load(model)
            self._loaded = model, finer
        t_s, joints = windows.base.t_s, len(model.joints.tree)
        worlds, stamps = t_s.shape
        starts = start_states(windows.base, self._X_BI)
        # The engine moves bodies by their speed at the end of a step; from half a step earlier a fall is exact.
        spans = t_s[:, 1:2] - t_s[:, :1]
        half_step = 0.5 * model.base.gravity_W * (spans / steps_for(spans, self._largest_step_s))
        starts[:, 7:10] -= half_step
        out = np.empty((worlds, stamps, _STATE + 2 * joints))
        for w in range(worlds):
            self._start(starts[w], windows.q0[w], windows.qd0[w])
            memory = [fresh_memory(law.hook, (1, 1)) if isinstance(law.hook, StepHook) else np.empty(0) for law in laws]
            out[w, 0] = self._row(joints)
            for k in range(1, stamps):
                self._advance(model, float(t_s[w, k - 1]), float(t_s[w, k]), wrenches, laws, memory)
                out[w, k] = self._row(joints)
        out[:, :, 7:10] += half_step[:, None]
        out = hold_last_valid(out)
        base: BodyMotion = measured_motion(out[:, :, :_STATE], self._X_BI)
        return LinkageMotion(base, out[:, :, _STATE : _STATE + joints], out[:, :, _STATE + joints :])

    def _load(self, model: LinkageModel) -> None:
        """Build an empty world with the linkage and the support, with the model's parameters."""
        client, tree = self._client, model.joints.tree
        empty_world(model.base, self._largest_step_s, client)
        frames = [_inertial_frame(model.base.com_B, model.base.inertia_B)]
        frames += [_inertial_frame(link.com_J, link.inertia_J) for link in tree]
        self._X_BI = frames[0][0]
        kinds = {False: pybullet.JOINT_REVOLUTE, True: pybullet.JOINT_PRISMATIC}
        with tempfile.TemporaryDirectory() as folder:
            shapes = [self._shape(s, Path(folder) / str(n)) for n, s in enumerate((model.base.shapes, *model.shapes))]
            self._handle = pybullet.createMultiBody(
                baseMass=model.base.mass_kg,
                baseCollisionShapeIndex=shapes[0],
                basePosition=[0.0, 0.0, PARKED_M],
                baseInertialFramePosition=frames[0][0][:3, 3].tolist(),
                baseInertialFrameOrientation=_quat_xyzw(frames[0][0]),
                linkMasses=[link.mass_kg for link in tree],
                linkCollisionShapeIndices=shapes[1:],
                linkVisualShapeIndices=[-1] * len(tree),
                linkPositions=[link.X_PJ[:3, 3].tolist() for link in tree],
                linkOrientations=[_quat_xyzw(link.X_PJ) for link in tree],
                linkInertialFramePositions=[X[:3, 3].tolist() for X, _ in frames[1:]],
                linkInertialFrameOrientations=[_quat_xyzw(X) for X, _ in frames[1:]],
                linkParentIndices=[link.parent + 1 for link in tree],
                linkJointTypes=[kinds[link.prismatic] for link in tree],
                linkJointAxis=[link.axis_J.tolist() for link in tree],
                physicsClientId=client,
            )
        # These turn a whole call to the base, whatever link it names; a mass would undo the inertia beside it.
        pybullet.changeDynamics(
            self._handle,
            -1,
            linearDamping=0.0,
            angularDamping=0.0,
            maxJointVelocity=LARGEST_RATE,
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=client,
        )
        for n, (_, moments) in enumerate(frames):
            pybullet.changeDynamics(
                self._handle,
                n - 1,
                localInertiaDiagonal=moments.tolist(),
                jointDamping=float(model.joints.damping[n - 1]) if n else 0.0,
                **contact_parameters(model.base),
                physicsClientId=client,
            )
        for j, link in enumerate(tree):
            if model.joints.limits is not None and np.isfinite(model.joints.limits[j]).all():
                low, high = model.joints.limits[j].tolist()
                limits = {"jointLowerLimit": low, "jointUpperLimit": high, "physicsClientId": client}
                pybullet.changeDynamics(self._handle, j, **limits)
            assert link.armature == 0.0, "no rigid link stands for an armature"

    def _shape(self, shapes: Sequence[CollisionShape], folder: Path) -> int:
        if not shapes:
            return -1
        folder.mkdir()
        shape = compound(shapes, 1.0, folder, self._client)
        clear_margins(shape, len(shapes), self._client)
        return shape

    def _start(self, row: FloatArray, q: FloatArray, qd: FloatArray) -> None:
        """Park for one step, which empties the contact caches, then place base and joints."""
        self._place([0.0, 0.0, PARKED_M], row[3:7].tolist(), [0.0] * 3, [0.0] * 3, q, 0.0 * qd)
        pybullet.setTimeStep(self._largest_step_s, physicsClientId=self._client)
        self._hold(np.zeros(len(q)), np.zeros(len(q)))
        pybullet.stepSimulation(physicsClientId=self._client)
        self._place(row[:3].tolist(), row[3:7].tolist(), row[7:10].tolist(), row[10:].tolist(), q, qd)

    def _place(
        self, at: list[float], quat: list[float], v_W: list[float], w_W: list[float], q: FloatArray, qd: FloatArray
    ) -> None:
        for j in range(len(q)):
            pybullet.resetJointState(self._handle, j, float(q[j]), float(qd[j]), physicsClientId=self._client)
        pybullet.resetBasePositionAndOrientation(self._handle, at, quat, physicsClientId=self._client)
        pybullet.resetBaseVelocity(self._handle, v_W, w_W, physicsClientId=self._client)

    def _advance(
        self,
        model: LinkageModel,
        from_s: float,
        to_s: float,
        wrenches: Sequence[tuple[BodyWrench, Params]],
        laws: Sequence[Law],
        memory: Sequence[FloatArray],
    ) -> None:
        """Equal steps from one moment to another."""
        if to_s <= from_s:
            return
        client, steps = self._client, int(steps_for(to_s - from_s, self._largest_step_s))
        h = (to_s - from_s) / steps
        # Before the motors: the engine turns their limits of effort into impulses when they are set.
        pybullet.setTimeStep(h, physicsClientId=client)
        held = max(1, int(HOLD_S / h))
        torque: list[float] | None = None
        self._hold(np.zeros(len(model.joints.tree)), model.joints.friction)
        for s in range(steps):
            if wrenches and s % held == 0:
                torque = self._pull(model, from_s + s * h, wrenches)
            if torque is not None:
                pybullet.applyExternalTorque(self._handle, -1, torque, pybullet.WORLD_FRAME, client)
            if laws:
                self._hold(*self._efforts(model, from_s + s * h, h, laws, memory))
            pybullet.stepSimulation(physicsClientId=client)
        if wrenches:
            pybullet.setGravity(*model.base.gravity_W.tolist(), physicsClientId=client)

    def _hold(self, effort: FloatArray, friction: FloatArray) -> None:
        """Apply joint efforts, and dry friction as a velocity motor with target 0 and limited force."""
        for j in range(len(effort)):
            # The default gain of 0.1 would stop a tenth of the rate per step: stiction would creep.
            dry = {"targetVelocity": 0.0, "velocityGain": 1.0, "force": float(friction[j])}
            pybullet.setJointMotorControl2(
                self._handle, j, pybullet.VELOCITY_CONTROL, **dry, physicsClientId=self._client
            )
            if effort[j] != 0.0:
                torque = {"force": float(effort[j]), "physicsClientId": self._client}
                pybullet.setJointMotorControl2(self._handle, j, pybullet.TORQUE_CONTROL, **torque)

    def _efforts(
        self, model: LinkageModel, t_s: float, dt_s: float, laws: Sequence[Law], memory: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Joint efforts (j,) and dry friction (j,) now."""
        row = self._row(len(model.joints.tree))
        q, qd = np.split(row[None, _STATE:], 2, axis=1)
        effort, largest = np.zeros_like(q), np.array(model.joints.friction, dtype=float)[None]
        for law, law_memory in zip(laws, memory, strict=True):
            column = np.s_[:, law.joint : law.joint + 1]
            now = JointState(np.array([[t_s]]), q[column], qd[column], np.zeros((1, 1)), dt_s)
            if isinstance(law.hook, JointTorque):
                effort[column] += step_value(law.hook, now, law.params, law_memory)
            elif isinstance(law.hook, JointFriction):
                direction = np.where(qd[column] < 0.0, -1.0, 1.0)
                now = now._replace(load=np.zeros((1, 1)), friction=largest[column].copy(), direction=direction)
                largest[column] += step_value(law.hook, now, law.params, law_memory)
        return effort[0], np.maximum(largest[0], 0.0)

    def _pull(
        self, model: LinkageModel, t_s: float, wrenches: Sequence[tuple[BodyWrench, Params]]
    ) -> list[float] | None:
        """Apply the forces on all links as gravity; returns the sum of the torques, for the base, if any."""
        row = self._row(0)
        quat_wxyz = np.roll(row[3:7], 1)
        state = BodyState(*(v[None] for v in (np.array([t_s]), row[:3], quat_wxyz, row[7:10], row[10:13])))
        pull, torque = model.base.gravity_W, np.zeros(3)
        for hook, params in wrenches:
            forces, torques = hook.wrench(state, params)
            pull, torque = pull + forces[0] / model.mass_kg, torque + torques[0]
        pybullet.setGravity(*pull.tolist(), physicsClientId=self._client)
        return torque.tolist() if torque.any() else None

    def _row(self, joints: int) -> FloatArray:
        """(13 + 2 j,) as `sim.bullet.body`, then joint positions, then their rates."""
        at = pybullet.getBasePositionAndOrientation(self._handle, physicsClientId=self._client)
        speed = pybullet.getBaseVelocity(self._handle, physicsClientId=self._client)
        states = pybullet.getJointStates(self._handle, range(joints), physicsClientId=self._client) if joints else ()
        return np.array([*at[0], *at[1], *speed[0], *speed[1], *(s[0] for s in states), *(s[1] for s in states)])


def _inertial_frame(com: FloatArray, inertia: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pose (4, 4) of the principal axes in the link, and the moments (3,)."""
    moments, quat_wxyz = principal_axes(inertia)
    return pose.pose_from_quat(quat_wxyz, com), moments


def _quat_xyzw(X: FloatArray) -> list[float]:
    return Rotation.from_matrix(X[:3, :3]).as_quat().tolist()
