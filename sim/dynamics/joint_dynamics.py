"""One velocity update of joints with dry friction: any tree; in closed form joints side by side and planar chains."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from schemas.model import FloatArray
from sim.dynamics.tree import Tree, inverse_dynamics, mass_matrix

_SWEEPS = 12
ComplexArray = NDArray[np.complex128]


class Posture(Protocol):
    """A tree under gravity at positions of its joints; all arrays (w, j)."""

    def bias(self, qd: FloatArray) -> FloatArray:
        """Effort that gravity and rotation ask for."""
        ...

    def load(self, qd: FloatArray) -> FloatArray:
        """Magnitude of the force that each bearing transmits, accelerations of the joints aside."""
        ...

    def needed(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Effort that the motion takes, friction aside."""
        ...

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """Rates after a step of length h (w, 1) under a net effort, with implicit viscous damping (j,)."""
        ...

    def held(self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """Rates `free` after the impulses of friction, each at most `largest`, that come nearest to stopping."""
        ...


class JointDynamics(Protocol):
    """A tree under gravity."""

    def at(self, q: FloatArray) -> Posture:
        """The tree at joint positions (w, j): what depends on them alone is worked out once."""
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

    @cached_property
    def turned(self) -> bool:
        """Whether gravity asks for another effort elsewhere."""
        return bool(self.along.any() or self.across.any())

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

    def at(self, q: FloatArray) -> SeparatePosture:
        """See `JointDynamics`."""
        return SeparatePosture(self, q)


@dataclass(frozen=True)
class SeparatePosture:
    """See `Posture`."""

    joints: SeparateJoints
    q: FloatArray

    def bias(self, qd: FloatArray) -> FloatArray:
        """See `Posture`."""
        if not self.joints.turned:
            return self.joints.level
        return self.joints.level + self.joints.along * np.cos(self.q) + self.joints.across * np.sin(self.q)

    def load(self, qd: FloatArray) -> FloatArray:
        """See `Posture`."""
        joints, rate2 = self.joints, qd**2
        inward = joints.pull[0] + joints.pull[1] * np.cos(self.q) + joints.pull[2] * np.sin(self.q)
        load2 = joints.weight2 - 2.0 * rate2 * inward + (joints.spin * rate2) ** 2
        return np.sqrt(np.maximum(load2, 0.0))

    def needed(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """See `Posture`."""
        return self.joints.inertia * qdd + self.bias(qd)

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Posture`."""
        inertia = self.joints.inertia
        return (inertia * qd + h * effort) / (inertia + h * damping)

    def held(self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Posture`."""
        change = largest / (self.joints.inertia + h * damping)
        return free - np.minimum(np.maximum(free, -change), change)


@dataclass(frozen=True)
class CoupledJoints:
    """Any tree."""

    tree: Tree
    gravity_W: FloatArray

    def at(self, q: FloatArray) -> CoupledPosture:
        """See `JointDynamics`."""
        return CoupledPosture(self.tree, self.gravity_W, q)


@dataclass(frozen=True)
class CoupledPosture:
    """See `Posture`."""

    tree: Tree
    gravity_W: FloatArray
    q: FloatArray

    @cached_property
    def mass(self) -> FloatArray:
        """(w, j, j) mass matrix."""
        return mass_matrix(self.tree, self.q)

    def bias(self, qd: FloatArray) -> FloatArray:
        """See `Posture`."""
        return inverse_dynamics(self.tree, self.q, qd, np.zeros_like(qd), self.gravity_W)[0]

    def load(self, qd: FloatArray) -> FloatArray:
        """See `Posture`."""
        return inverse_dynamics(self.tree, self.q, qd, np.zeros_like(qd), self.gravity_W)[1]

    def needed(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """See `Posture`."""
        return inverse_dynamics(self.tree, self.q, qd, qdd, self.gravity_W)[0]

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Posture`."""
        return _coupled_rates(self.mass, qd, effort, damping, h)

    def held(self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Posture`."""
        return _coupled_held(self.mass, free, largest, damping, h)


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

    @cached_property
    def own(self) -> tuple[FloatArray, FloatArray]:
        """(j, j) diagonal matrices of `turning` and `armature`."""
        return np.diag(self.turning), np.diag(self.armature)

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

    def at(self, q: FloatArray) -> PlanarPosture:
        """See `JointDynamics`."""
        at = np.exp(1j * np.add.accumulate(q + self.zero, axis=1))
        return PlanarPosture(self, at, self.coupled * at.conj()[:, :, None] * at[:, None, :])


@dataclass(frozen=True)
class PlanarPosture:
    """See `Posture`: `at` (w, j) unit numbers of the absolute angles, `between` (w, j, j) how the links are coupled."""

    chain: PlanarChain
    at: ComplexArray
    between: ComplexArray

    @cached_property
    def mass(self) -> FloatArray:
        """(w, j, j) mass matrix."""
        turning, armature = self.chain.own
        return _onto_joints(_onto_joints(self.between.real + turning).swapaxes(1, 2)) + armature

    def bias(self, qd: FloatArray) -> FloatArray:
        """See `Posture`."""
        rate2 = np.add.accumulate(qd, axis=1) ** 2
        pull = (self.chain.weight * self.at).conj() * self.chain.gravity
        return -_onto_joints(np.einsum("wij,wj->wi", self.between.imag, rate2) + pull.imag)

    def load(self, qd: FloatArray) -> FloatArray:
        """See `Posture`."""
        chain, rate2 = self.chain, np.add.accumulate(qd, axis=1) ** 2
        inward = -(self.at * rate2) @ chain.outboard.T - chain.carried * chain.gravity
        return np.sqrt(inward.real**2 + inward.imag**2 + (chain.carried * chain.aside) ** 2)

    def needed(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """See `Posture`."""
        return np.einsum("wij,wj->wi", self.mass, qdd) + self.bias(qd)

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Posture`."""
        return _coupled_rates(self.mass, qd, effort, damping, h)

    def held(self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Posture`."""
        return _coupled_held(self.mass, free, largest, damping, h)


def _onto_joints(absolute: FloatArray) -> FloatArray:
    """Efforts on absolute angles (w, j, ...) as joint efforts: a joint turns all links from its own on."""
    return np.add.accumulate(absolute[:, ::-1], axis=1)[:, ::-1]


def _coupled_rates(M: FloatArray, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
    momentum = np.einsum("wij,wj->wi", M, qd) + h * effort
    return _solved(_damped(M, damping, h), momentum.T).T


def _damped(M: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
    """Mass matrices with implicit damping."""
    return M + h[:, :, None] * np.diag(damping) if damping.any() else M


def _coupled_held(
    M: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
) -> FloatArray:
    """Projected Gauss-Seidel over the joints, as engines do for contacts."""
    # Joint by joint from here on, worlds side by side: (j, j, w) and (j, w).
    A, units = _damped(M, damping, h), np.eye(M.shape[1])[:, :, None]
    inverse = np.stack([_solved(A, unit) for unit in units], axis=1)
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


def _solved(A: FloatArray, b: FloatArray) -> FloatArray:
    """x (j, w) with A x = b, for symmetric positive definite A (w, j, j) and b (j, w), which needs no pivots.

    Elimination joint by joint over all worlds at once: for a few joints a fraction of the cost of a call per world.
    """
    n = A.shape[1]
    upper = [[A[:, i, k] for k in range(n)] for i in range(n)]
    x = list(b)
    for i in range(n):
        for k in range(i + 1, n):
            share = upper[i][k] / upper[i][i]
            x[k] = x[k] - share * x[i]
            for m in range(k, n):
                upper[k][m] = upper[k][m] - share * upper[i][m]
    for i in reversed(range(n)):
        for k in range(i + 1, n):
            x[i] = x[i] - upper[i][k] * x[k]
        x[i] = x[i] / upper[i][i]
    return np.stack(x)
