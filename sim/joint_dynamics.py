"""One velocity update of joints with dry friction: any tree; in closed form joints side by side and planar chains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from schemas.model import FloatArray
from sim.tree import Tree, inverse_dynamics, mass_matrix

_SWEEPS = 12
ComplexArray = NDArray[np.complex128]


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
    if _planar(tree):
        return PlanarChain.of(tree, gravity_W)
    return CoupledJoints(tree, gravity_W)


def _planar(tree: Tree) -> bool:
    """Whether the links hang on one another and all turn about y."""
    y = np.array([0.0, 1.0, 0.0])
    return all(
        link.parent == i - 1
        and not link.prismatic
        and np.allclose(link.axis_J, y, atol=1e-12)
        and np.allclose(link.X_PJ[:3, :3] @ y, y, atol=1e-12)
        for i, link in enumerate(tree)
    )


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
    """Any tree."""

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
        return _coupled_rates(mass_matrix(self.tree, q), qd, effort, damping, h)

    def held(
        self, q: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `JointDynamics`."""
        return _coupled_held(mass_matrix(self.tree, q), free, largest, damping, h)


@dataclass(frozen=True)
class PlanarChain:
    """Links that hang on one another and all turn about y, as complex numbers z + i x of that plane.

    With absolute angles t the mass centre of link l is sum_k a_lk exp(i t_k), where a_lk is the offset to the next
    joint (k < l), or of the mass centre (k = l). Masses times these give all that follows.
    """

    zero: FloatArray  # (j,) constant angle of each joint frame in its parent's
    coupled: ComplexArray  # (j, j) sum over links of m conj(a_i) a_j
    turning: FloatArray  # (j,) inertia about y and each mass centre
    armature: FloatArray
    weight: ComplexArray  # (j,) sum over links of m a_i times the gravity factor
    outboard: ComplexArray  # (j, j) sum over links from i on of m a_j
    carried: FloatArray  # (j,) mass from i on times the gravity factor
    gravity: complex
    aside: float  # gravity along y

    @staticmethod
    def of(tree: Tree, gravity_W: FloatArray) -> PlanarChain:
        """Sums over the links of a tree for which `_planar` holds."""
        n = len(tree)
        a = np.zeros((n, n), dtype=complex)
        for i, link in enumerate(tree):
            a[i, i] = complex(link.com_J[2], link.com_J[0])
            if i + 1 < n:
                a[i + 1 :, i] = complex(tree[i + 1].X_PJ[2, 3], tree[i + 1].X_PJ[0, 3])
        mass = np.array([link.mass_kg for link in tree])
        factor = np.array([link.gravity_factor for link in tree])
        return PlanarChain(
            zero=np.array([np.arctan2(link.X_PJ[0, 2], link.X_PJ[2, 2]) for link in tree]),
            coupled=np.einsum("l,li,lj->ij", mass, a.conj(), a),
            turning=np.array([link.inertia_J[1, 1] for link in tree]),
            armature=np.array([link.armature for link in tree]),
            weight=(mass * factor) @ a,
            outboard=np.stack([mass[i:] @ a[i:] for i in range(n)]),
            carried=np.array([(mass * factor)[i:].sum() for i in range(n)]),
            gravity=complex(gravity_W[2], gravity_W[0]),
            aside=float(gravity_W[1]),
        )

    def bias(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `JointDynamics`."""
        at = self._directions(q)
        rate2 = np.add.accumulate(qd, axis=1) ** 2
        between = self.coupled * at.conj()[:, :, None] * at[:, None, :]
        pull = (self.weight * at).conj() * self.gravity
        absolute = -np.einsum("wij,wj->wi", between.imag, rate2) - pull.imag
        inward = -(at * rate2) @ self.outboard.T - self.carried * self.gravity
        load = np.sqrt(inward.real**2 + inward.imag**2 + (self.carried * self.aside) ** 2)
        return _onto_joints(absolute), load

    def needed(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `JointDynamics`."""
        bias, load = self.bias(q, qd)
        return np.einsum("wij,wj->wi", self._mass_matrix(q), qdd) + bias, load

    def free_rates(
        self, q: FloatArray, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `JointDynamics`."""
        return _coupled_rates(self._mass_matrix(q), qd, effort, damping, h)

    def held(
        self, q: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `JointDynamics`."""
        return _coupled_held(self._mass_matrix(q), free, largest, damping, h)

    def _directions(self, q: FloatArray) -> ComplexArray:
        """(w, j) unit numbers of the absolute angles."""
        return np.exp(1j * np.add.accumulate(q + self.zero, axis=1))

    def _mass_matrix(self, q: FloatArray) -> FloatArray:
        at = self._directions(q)
        absolute = (self.coupled * at.conj()[:, :, None] * at[:, None, :]).real + np.diag(self.turning)
        return _onto_joints(_onto_joints(absolute).swapaxes(1, 2)) + np.diag(self.armature)


def _onto_joints(absolute: FloatArray) -> FloatArray:
    """Efforts on absolute angles (w, j, ...) as joint efforts: a joint turns all links from its own on."""
    return np.add.accumulate(absolute[:, ::-1], axis=1)[:, ::-1]


def _coupled_rates(M: FloatArray, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
    momentum = np.einsum("wij,wj->wi", M, qd) + h * effort
    return np.linalg.solve(M + h[:, :, None] * np.diag(damping), momentum[..., None])[..., 0]


def _coupled_held(
    M: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
) -> FloatArray:
    """Projected Gauss-Seidel over the joints, as engines do for contacts."""
    # Joint by joint from here on, worlds side by side: (j, j, w) and (j, w).
    inverse = np.linalg.inv(M + h[:, :, None] * np.diag(damping)).transpose(1, 2, 0).copy()
    most, rates = largest.T.copy(), free.T.copy()
    impulse = np.zeros_like(rates)
    for _ in range(_SWEEPS):
        before = impulse.copy()
        for j in range(len(rates)):
            wanted = impulse[j] - rates[j] / inverse[j, j]
            given = np.minimum(np.maximum(wanted, -most[j]), most[j])
            rates += inverse[:, j] * (given - impulse[j])
            impulse[j] = given
        if np.array_equal(before, impulse):  # All slide, or rest: no sweep changes anything any more.
            break
    return rates.T
