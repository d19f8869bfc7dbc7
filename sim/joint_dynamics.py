"""One velocity update of joints with dry friction: for coupled chains, and in closed form for joints side by side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from schemas.model import FloatArray
from sim.tree import Tree, inverse_dynamics, mass_matrix

_SWEEPS = 12


class JointDynamics(Protocol):
    """A tree under gravity; all arrays (w, j)."""

    def bias(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Effort that gravity and rotation ask for, and the load of each bearing."""
        ...

    def needed(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Effort that the motion takes, friction aside, and the load of each bearing without its acceleration."""
        ...

    def free_rates(
        self, q: FloatArray, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """Rates after a step of length h (w, 1) under a net effort, with implicit viscous damping (j,)."""
        ...

    def held(
        self, q: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """Rates `free` after the impulses of friction, each at most `largest`, that come nearest to stopping."""
        ...


def joint_dynamics(tree: Tree, gravity_W: FloatArray) -> JointDynamics:
    """The fastest exact form: joints that hang on the base alone do not feel one another."""
    if all(link.parent < 0 for link in tree):
        return SeparateJoints.of(tree, gravity_W)
    return CoupledJoints(tree, gravity_W)


@dataclass(frozen=True)
class SeparateJoints:
    """Joints on a fixed base: constant inertia, gravity a cosine and a sine of the position; all (j,)."""

    inertia: FloatArray
    level: FloatArray  # bias = level + along * cos q + across * sin q
    along: FloatArray
    across: FloatArray
    weight2: FloatArray  # load^2 = weight2 - 2 qd^2 (pull_0 + pull_c cos q + pull_s sin q) + (spin qd^2)^2
    pull: FloatArray  # (3, j)
    spin: FloatArray

    @staticmethod
    def of(tree: Tree, gravity_W: FloatArray) -> SeparateJoints:
        """The closed form: moments of the weight about the axis with the link at zero and at a quarter turn."""
        slides = np.array([link.prismatic for link in tree])
        axis = np.stack([link.axis_J for link in tree])
        com = np.stack([link.com_J for link in tree])
        mass = np.array([link.mass_kg for link in tree])
        weight = np.array([link.gravity_factor for link in tree])[:, None] * mass[:, None]
        weight = weight * np.stack([gravity_W @ link.X_PJ[:3, :3] for link in tree])  # in the joint's frame at zero
        across = com - (com * axis).sum(axis=1)[:, None] * axis
        turning = np.array([link.axis_J @ link.inertia_J @ link.axis_J for link in tree])
        armature = np.array([link.armature for link in tree])
        moment = (axis * np.cross(com, weight)).sum(axis=1)
        quarter = (across * weight).sum(axis=1)
        pressed = weight - np.where(slides, (weight * axis).sum(axis=1), 0.0)[:, None] * axis
        lever2 = (across**2).sum(axis=1)
        return SeparateJoints(
            inertia=np.where(slides, mass, turning + mass * lever2) + armature,
            level=np.where(slides, -(weight * axis).sum(axis=1), 0.0),
            along=np.where(slides, 0.0, -moment),
            across=np.where(slides, 0.0, quarter),
            weight2=(pressed**2).sum(axis=1),
            pull=np.where(slides, 0.0, -mass * np.stack([0.0 * mass, quarter, moment])),
            spin=np.where(slides, 0.0, mass * np.sqrt(lever2)),
        )

    def bias(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `JointDynamics`."""
        c, s = np.cos(q), np.sin(q)
        rate2 = qd**2
        inward = self.pull[0] + self.pull[1] * c + self.pull[2] * s
        load2 = self.weight2 - 2.0 * rate2 * inward + (self.spin * rate2) ** 2
        return self.level + self.along * c + self.across * s, np.sqrt(np.maximum(load2, 0.0))

    def needed(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `JointDynamics`."""
        bias, load = self.bias(q, qd)
        return self.inertia * qdd + bias, load

    def free_rates(
        self, q: FloatArray, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `JointDynamics`."""
        return (self.inertia * qd + h * effort) / (self.inertia + h * damping)

    def held(
        self, q: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `JointDynamics`."""
        change = largest / (self.inertia + h * damping)
        return free - np.clip(free, -change, change)


@dataclass(frozen=True)
class CoupledJoints:
    """Any tree; friction by projected Gauss-Seidel, as engines do for contacts."""

    tree: Tree
    gravity_W: FloatArray

    def bias(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `JointDynamics`."""
        return inverse_dynamics(self.tree, q, qd, np.zeros_like(q), self.gravity_W)

    def needed(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `JointDynamics`."""
        return inverse_dynamics(self.tree, q, qd, qdd, self.gravity_W)[0], self.bias(q, qd)[1]

    def free_rates(
        self, q: FloatArray, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `JointDynamics`."""
        M = mass_matrix(self.tree, q)
        momentum = np.einsum("wij,wj->wi", M, qd) + h * effort
        return np.linalg.solve(M + h[:, :, None] * np.diag(damping), momentum[..., None])[..., 0]

    def held(
        self, q: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `JointDynamics`."""
        inverse = np.linalg.inv(mass_matrix(self.tree, q) + h[:, :, None] * np.diag(damping))
        impulse, rates = np.zeros_like(free), free.copy()
        for _ in range(_SWEEPS):
            for j in range(free.shape[1]):
                wanted = impulse[:, j] - rates[:, j] / inverse[:, j, j]
                change = np.clip(wanted, -largest[:, j], largest[:, j]) - impulse[:, j]
                impulse[:, j] += change
                rates += inverse[:, :, j] * change[:, None]
        return rates
