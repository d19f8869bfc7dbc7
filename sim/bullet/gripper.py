"""The gripper of `sim.gripper_description` in PyBullet: loaded from its URDF, its mount driven, its fingers coupled."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pybullet

from formats.urdf.write import write_urdf
from geom import pose
from schemas.arrays import FloatArray
from schemas.physical_constants import GRAVITY_MPS2
from sim.grasp_trial import GraspTask
from sim.gripper_description import HAND, LEFT, LINK_KG, RIGHT, UP, describe_gripper, mount_joints
from sim.joint_handling import HandlingTask

_GEAR_FORCE_N = 1e4  # of the coupling, which must not give way
_GROUP, _OTHERS = 2, 1


class BulletGripper:
    """A gripper with its grip centre at X_WG (4, 4), lengths of the model, `scale` times as large as its true size.

    It is that of the task, opened as far; its mount turns about `turn_axis_W` (3,), its wrist if `turns_wrist`.
    """

    def __init__(
        self,
        client: int,
        task: GraspTask | HandlingTask,
        X_WG: FloatArray,
        scale: float,
        turn_axis_W: FloatArray = UP,
        *,
        turns_wrist: bool = False,
    ) -> None:
        self._client, self._link_kg = client, LINK_KG
        description = describe_gripper(
            task.gripper, task.opening_m, X_WG[:3, :3], scale, turn_axis_W, turns_wrist=turns_wrist
        )
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "gripper.urdf"
            file.write_bytes(write_urdf(description).data)
            self.handle = pybullet.loadURDF(
                str(file),
                basePosition=X_WG[:3, 3].tolist(),
                useFixedBase=1,
                flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
                physicsClientId=client,
            )
        joints = range(pybullet.getNumJoints(self.handle, physicsClientId=client))
        infos = [pybullet.getJointInfo(self.handle, j, physicsClientId=client) for j in joints]
        by_name = {info[1].decode(): info[0] for info in infos} | {info[12].decode(): info[0] for info in infos}
        self.left, self.right, self.hand = (by_name[name] for name in (LEFT, RIGHT, HAND))
        self._mount = [by_name[name] for name in mount_joints(turns_wrist)]
        self._count = len(infos)
        gear = pybullet.createConstraint(
            self.handle, self.left, self.handle, self.right, pybullet.JOINT_GEAR, [1, 0, 0], [0, 0, 0], [0, 0, 0],
            physicsClientId=client,
        )  # fmt: skip
        pybullet.changeConstraint(
            gear, gearRatio=-1, erp=0.5, maxForce=_GEAR_FORCE_N * scale**3, physicsClientId=client
        )
        # The pads have friction 1, as the engine multiplies both sides: the body has that of the pair.
        for link in range(self._count):
            pybullet.changeDynamics(
                self.handle, link, lateralFriction=1.0, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0,
                physicsClientId=client,
            )  # fmt: skip
            pybullet.setCollisionFilterGroupMask(self.handle, link, _GROUP, _OTHERS, physicsClientId=client)

    def place(self, mount: FloatArray) -> None:
        """Put the mount (5,) there at once, at rest; the wrist counts where it turns."""
        for joint, position in zip(self._mount, mount.tolist(), strict=False):
            pybullet.resetJointState(self.handle, joint, position, 0.0, physicsClientId=self._client)

    def mount(self) -> FloatArray:
        """(k,) positions of the mount."""
        return np.array([state[0] for state in self._mount_states()])

    def mount_efforts(self) -> FloatArray:
        """(k,) efforts of the motors of the mount in the last step."""
        return np.array([state[3] for state in self._mount_states()])

    def scale_mass(self, factor: float) -> None:
        """Mass and inertia of every link, `factor` times those of the description."""
        self._link_kg = factor * LINK_KG
        for link in range(self._count):
            moments = pybullet.getDynamicsInfo(self.handle, link, physicsClientId=self._client)[2]
            pybullet.changeDynamics(
                self.handle,
                link,
                mass=self._link_kg,
                localInertiaDiagonal=[factor * moment for moment in moments],
                physicsClientId=self._client,
            )

    def carry_weight(self) -> None:
        """Take the weight off the gripper for the next step, as an arm does that compensates gravity."""
        links = range(self._count)
        states = pybullet.getLinkStates(self.handle, links, physicsClientId=self._client)
        for link, state in zip(links, states, strict=True):
            pybullet.applyExternalForce(
                self.handle,
                link,
                [0.0, 0.0, self._link_kg * GRAVITY_MPS2],
                state[0],
                pybullet.WORLD_FRAME,
                physicsClientId=self._client,
            )

    def _mount_states(self) -> Sequence[Sequence[Any]]:
        return pybullet.getJointStates(self.handle, self._mount, physicsClientId=self._client)

    def set_friction(self, friction: float) -> None:
        """Friction of pads and hand; the engine multiplies it with that of what they touch."""
        for link in range(self._count):
            pybullet.changeDynamics(self.handle, link, lateralFriction=friction, physicsClientId=self._client)

    def drive(self, mount: FloatArray, rate: FloatArray, efforts: float | FloatArray) -> None:
        """Motors of the mount towards positions at rates (5,), with efforts at most, or one for all; those of the wrist
        count where it turns.
        """
        count = len(self._mount)
        pybullet.setJointMotorControlArray(
            self.handle,
            self._mount,
            pybullet.POSITION_CONTROL,
            targetPositions=mount[:count].tolist(),
            targetVelocities=rate[:count].tolist(),
            forces=np.broadcast_to(efforts, count).tolist(),
            positionGains=[0.3] * count,
            velocityGains=[1.0] * count,
            physicsClientId=self._client,
        )

    def move_fingers(self, speed: float, force_n: float) -> None:
        """Motors of both fingers at a speed, positive to close, with at most that force each."""
        for finger in (self.left, self.right):
            pybullet.setJointMotorControl2(
                self.handle,
                finger,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=speed,
                force=force_n,
                physicsClientId=self._client,
            )

    def boxes(self) -> FloatArray:
        """X_WB (3, 4, 4) of left finger, right finger and hand, lengths of the model."""
        return np.stack([self._link_pose(link) for link in (self.left, self.right, self.hand)])

    def _link_pose(self, link: int) -> FloatArray:
        state = pybullet.getLinkState(self.handle, link, physicsClientId=self._client)
        return pose.pose_from_quat(pose.to_wxyz(np.asarray(state[1])), state[0])

    def touches(self, body: int, link: int | None = None) -> bool:
        """Whether that link of the gripper touches the body; without one, whether any does."""
        between = {} if link is None else {"linkIndexA": link, "linkIndexB": -1}
        return bool(pybullet.getContactPoints(self.handle, body, **between, physicsClientId=self._client))
