"""Velocity update (rad/s, m/s) of joints with dry friction: any tree; closed forms for two simple kinds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from schemas.arrays import ComplexArray, FloatArray
from sim.dynamics.tree import Tree, inverse_dynamics, mass_matrix

_SWEEPS = 12


class Configuration(Protocol):
    """A tree under gravity at positions of its joints; all arrays (w, j)."""

    def bias(self, qd: FloatArray) -> FloatArray:
        """Bias effort: gravity and velocity products."""
        ...

    def load(self, qd: FloatArray) -> FloatArray:
        """Magnitude of the force that each bearing transmits, without that of joint accelerations."""
        ...

    def required_effort(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Effort that causes the motion, without friction (inverse dynamics)."""
        ...

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """Rates after a step of length h (w, 1) under a net effort, with implicit viscous damping (j,)."""
        ...

    def with_dry_friction(
        self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """Rates `free` after the impulses of friction, each at most `largest`, that come nearest to stopping."""
        ...


class JointDynamics(Protocol):
    """A tree under gravity."""

    def at(self, q: FloatArray) -> Configuration:
        """The tree at joint positions (w, j): terms that depend on them alone are computed once."""
        ...


def joint_dynamics(tree: Tree, gravity_W: FloatArray) -> JointDynamics:
    """The fastest exact form: joints mounted on the base alone are not coupled."""
    if all(link.parent < 0 for link in tree):
        return SeparateJoints.of(tree, gravity_W)
    if _planar(tree):
        return PlanarChain.of(tree, gravity_W)
    return CoupledJoints(tree, gravity_W)


def _planar(tree: Tree) -> bool:
    """Whether the links form one chain and all turn about y."""
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
    def gravity_varies(self) -> bool:
        """Whether the effort of gravity depends on the position."""
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

    def at(self, q: FloatArray) -> SeparateConfiguration:
        """See `JointDynamics`."""
        return SeparateConfiguration(self, q)


@dataclass(frozen=True)
class SeparateConfiguration:
    """See `Configuration`."""

    joints: SeparateJoints
    q: FloatArray

    def bias(self, qd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        if not self.joints.gravity_varies:
            return self.joints.level
        return self.joints.level + self.joints.along * np.cos(self.q) + self.joints.across * np.sin(self.q)

    def load(self, qd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        joints, rate2 = self.joints, qd**2
        inward = joints.pull[0] + joints.pull[1] * np.cos(self.q) + joints.pull[2] * np.sin(self.q)
        load2 = joints.weight2 - 2.0 * rate2 * inward + (joints.spin * rate2) ** 2
        return np.sqrt(np.maximum(load2, 0.0))

    def required_effort(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        return self.joints.inertia * qdd + self.bias(qd)

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Configuration`."""
        inertia = self.joints.inertia
        return (inertia * qd + h * effort) / (inertia + h * damping)

    def with_dry_friction(
        self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `Configuration`."""
        change = largest / (self.joints.inertia + h * damping)
        return free - np.minimum(np.maximum(free, -change), change)


@dataclass(frozen=True)
class CoupledJoints:
    """Joints of any tree, coupled by its mass matrix."""

    tree: Tree
    gravity_W: FloatArray

    def at(self, q: FloatArray) -> CoupledConfiguration:
        """See `JointDynamics`."""
        return CoupledConfiguration(self.tree, self.gravity_W, q)


@dataclass(frozen=True)
class CoupledConfiguration:
    """See `Configuration`."""

    tree: Tree
    gravity_W: FloatArray
    q: FloatArray

    @cached_property
    def mass(self) -> FloatArray:
        """(w, j, j) mass matrix."""
        return mass_matrix(self.tree, self.q)

    def bias(self, qd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        return inverse_dynamics(self.tree, self.q, qd, np.zeros_like(qd), self.gravity_W)[0]

    def load(self, qd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        return inverse_dynamics(self.tree, self.q, qd, np.zeros_like(qd), self.gravity_W)[1]

    def required_effort(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        return inverse_dynamics(self.tree, self.q, qd, qdd, self.gravity_W)[0]

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Configuration`."""
        return _coupled_rates(self.mass, qd, effort, damping, h)

    def with_dry_friction(
        self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `Configuration`."""
        return _coupled_with_friction(self.mass, free, largest, damping, h)


@dataclass(frozen=True)
class PlanarChain:
    """One chain of links that all turn about y, as complex numbers z + i x of that plane.

    With absolute angles t the mass centre of link l is sum_k a_lk exp(i t_k), where a_lk is the offset to the next
    joint (k < l), or of the mass centre (k = l). Masses times these give all that follows.
    """

    zero: FloatArray  # (j,) constant angle of each joint frame in its parent's
    coupled: ComplexArray  # (j, j) sum over links of m conj(a_i) a_j
    turning: FloatArray  # (j,) inertia about y and each mass centre
    armature: FloatArray
    weight: ComplexArray  # (j,) sum over links of m a_i times the gravity factor
    outboard: ComplexArray  # (j, j) sum over links from i on of m a_j
    outboard_mass: FloatArray  # (j,) mass from i on times the gravity factor
    gravity: complex
    gravity_y: float  # gravity along y

    @cached_property
    def diagonals(self) -> tuple[FloatArray, FloatArray]:
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
            outboard_mass=np.array([(mass * factor)[i:].sum() for i in range(n)]),
            gravity=complex(gravity_W[2], gravity_W[0]),
            gravity_y=float(gravity_W[1]),
        )

    def at(self, q: FloatArray) -> PlanarConfiguration:
        """See `JointDynamics`."""
        at = np.exp(1j * np.add.accumulate(q + self.zero, axis=1))
        return PlanarConfiguration(self, at, self.coupled * at.conj()[:, :, None] * at[:, None, :])


@dataclass(frozen=True)
class PlanarConfiguration:
    """See `Configuration`: `at` (w, j) unit numbers of the absolute angles, `between` (w, j, j) their coupling."""

    chain: PlanarChain
    at: ComplexArray
    between: ComplexArray

    @cached_property
    def mass(self) -> FloatArray:
        """(w, j, j) mass matrix."""
        turning, armature = self.chain.diagonals
        return _onto_joints(_onto_joints(self.between.real + turning).swapaxes(1, 2)) + armature

    def bias(self, qd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        rate2 = np.add.accumulate(qd, axis=1) ** 2
        pull = (self.chain.weight * self.at).conj() * self.chain.gravity
        return -_onto_joints(np.einsum("wij,wj->wi", self.between.imag, rate2) + pull.imag)

    def load(self, qd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        chain, rate2 = self.chain, np.add.accumulate(qd, axis=1) ** 2
        inward = -(self.at * rate2) @ chain.outboard.T - chain.outboard_mass * chain.gravity
        return np.sqrt(inward.real**2 + inward.imag**2 + (chain.outboard_mass * chain.gravity_y) ** 2)

    def required_effort(self, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """See `Configuration`."""
        return np.einsum("wij,wj->wi", self.mass, qdd) + self.bias(qd)

    def free_rates(self, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
        """See `Configuration`."""
        return _coupled_rates(self.mass, qd, effort, damping, h)

    def with_dry_friction(
        self, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
    ) -> FloatArray:
        """See `Configuration`."""
        return _coupled_with_friction(self.mass, free, largest, damping, h)


def _onto_joints(absolute: FloatArray) -> FloatArray:
    """Efforts on absolute angles (w, j, ...) as joint efforts: a joint turns all links from its own on."""
    return np.add.accumulate(absolute[:, ::-1], axis=1)[:, ::-1]


def _coupled_rates(M: FloatArray, qd: FloatArray, effort: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
    momentum = np.einsum("wij,wj->wi", M, qd) + h * effort
    return _solve_positive_definite(_damped(M, damping, h), momentum.T).T


def _damped(M: FloatArray, damping: FloatArray, h: FloatArray) -> FloatArray:
    """Mass matrices with implicit damping."""
    return M + h[:, :, None] * np.diag(damping) if damping.any() else M


def _coupled_with_friction(
    M: FloatArray, free: FloatArray, largest: FloatArray, damping: FloatArray, h: FloatArray
) -> FloatArray:
    """Projected Gauss-Seidel over the joints, as engines do for contacts."""
    # Joint by joint from here on, worlds side by side: (j, j, w) and (j, w).
    A, units = _damped(M, damping, h), np.eye(M.shape[1])[:, :, None]
    inverse = np.stack([_solve_positive_definite(A, unit) for unit in units], axis=1)
    limits, rates = largest.T.copy(), free.T.copy()
    impulse = np.zeros_like(rates)
    for _ in range(_SWEEPS):
        before = impulse.copy()
        for j in range(len(rates)):
            target = impulse[j] - rates[j] / inverse[j, j]
            applied = np.minimum(np.maximum(target, -limits[j]), limits[j])
            rates += inverse[:, j] * (applied - impulse[j])
            impulse[j] = applied
        if np.array_equal(before, impulse):  # All slide, or rest: no sweep changes anything any more.
            break
    return rates.T


def _solve_positive_definite(A: FloatArray, b: FloatArray) -> FloatArray:
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
