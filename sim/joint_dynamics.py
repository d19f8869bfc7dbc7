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
        """The closed form, read off the general equations at four positions and with one turn rate."""
        n = len(tree)
        zero = np.zeros((1, n))

        def at(angle: float, rate: float) -> tuple[FloatArray, FloatArray]:
            effort, load = inverse_dynamics(tree, zero + angle, zero + rate, zero, gravity_W)
            return effort[0], load[0]

        (b0, _), (b1, _), (b2, _) = (at(a, 0.0) for a in (0.0, np.pi / 2, np.pi))
        slides = np.array([link.prismatic for link in tree])
        level = np.where(slides, b0, 0.5 * (b0 + b2))
        weight = at(0.0, 0.0)[1]
        lever = np.array([np.linalg.norm(np.cross(link.axis_J, link.com_J)) for link in tree])
        mass = np.array([link.mass_kg for link in tree])
        spin = np.where(slides, 0.0, mass * lever)

        def pull(angle: float) -> FloatArray:
            load = at(angle, 1.0)[1]
            return 0.5 * (weight**2 + spin**2 - load**2)

        p0, p1, p2 = pull(0.0), pull(np.pi / 2), pull(np.pi)
        middle = np.where(slides, 0.0, 0.5 * (p0 + p2))
        return SeparateJoints(
            inertia=mass_matrix(tree, zero)[0].diagonal().copy(),
            level=level,
            along=np.where(slides, 0.0, b0 - level),
            across=np.where(slides, 0.0, b1 - level),
            weight2=weight**2,
            pull=np.where(slides, 0.0, np.stack([middle, p0 - middle, p1 - middle])),
            spin=spin,
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
