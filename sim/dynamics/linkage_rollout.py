"""Protocol and data of roll-outs of a free body with joints from measured states (SI units).

Implementation: `sim.bullet.linkage`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from schemas.arrays import FloatArray
from schemas.physics import CollisionShape
from sim.dynamics.body_rollout import BodyModel, BodyMotion, BodyWindows
from sim.dynamics.hooks import BodyWrench, Params
from sim.dynamics.mechanism import Law, MechanismModel
from sim.dynamics.tree import placements


@dataclass(frozen=True)
class LinkageModel:
    """A measured base body and the links attached to it by joints.

    base     the measured body with the support, gravity and contact numbers that hold for all links.
    joints   tree (parent -1: the base), dry friction and damping; its gravity and drive are not used.
    shapes   convex shapes per link of the tree, posed in the link's frame.
    names    of the bodies: the base, then the links of the tree.
    """

    base: BodyModel
    joints: MechanismModel
    shapes: tuple[tuple[CollisionShape, ...], ...]
    names: tuple[str, ...]

    @property
    def mass_kg(self) -> float:
        """Total mass of base and links."""
        return self.base.mass_kg + sum(link.mass_kg for link in self.joints.tree)


@dataclass(frozen=True)
class LinkageWindows:
    """Where roll-outs start: the base's windows; joint positions and rates q0, qd0 (w, j)."""

    base: BodyWindows
    q0: FloatArray
    qd0: FloatArray


@dataclass(frozen=True)
class LinkageMotion:
    """The base's motion, and joint positions and rates q, qd (w, k, j)."""

    base: BodyMotion
    q: FloatArray
    qd: FloatArray


class LinkageRollout(Protocol):
    """Simulates windows one by one; equal calls give equal results, whatever was simulated before."""

    def rollout(
        self,
        model: LinkageModel,
        windows: LinkageWindows,
        wrenches: Sequence[tuple[BodyWrench, Params]] = (),
        laws: Sequence[Law] = (),
        finer: float = 1.0,
    ) -> LinkageMotion:
        """The motion from each start. `wrenches` act on every link by its share of the mass; `laws` on joints."""
        ...

    def close(self) -> None:
        """Free the engine's world; the object cannot be used afterwards."""
        ...


def link_body(model: LinkageModel, name: str) -> BodyModel:
    """The link of that name as a free body, with the contact numbers of the base. Raises ValueError."""
    at = model.names.index(name)
    if at == 0:
        return model.base
    link = model.joints.tree[at - 1]
    link_mass = {"mass_kg": link.mass_kg, "com_B": link.com_J, "inertia_B": link.inertia_J}
    return replace(model.base, shapes=model.shapes[at - 1], **link_mass)


def with_link_body(model: LinkageModel, name: str, body: BodyModel) -> LinkageModel:
    """The model with mass, mass centre, inertia and shapes of that link as in `body`."""
    at = model.names.index(name)
    if at == 0:
        return replace(model, base=body)
    tree, shapes = list(model.joints.tree), list(model.shapes)
    tree[at - 1] = replace(tree[at - 1], mass_kg=body.mass_kg, com_J=body.com_B, inertia_J=body.inertia_B)
    shapes[at - 1] = body.shapes
    return replace(model, joints=replace(model.joints, tree=tuple(tree)), shapes=tuple(shapes))


def link_poses(model: LinkageModel, q: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Rotation (n, 3, 3) and position (n, 3) of every link in the base's frame, the base first; q (n, j)."""
    poses = [(np.broadcast_to(np.eye(3), (len(q), 3, 3)), np.zeros((len(q), 3)))]
    for link, R_PJ, p_PJ in zip(model.joints.tree, *placements(model.joints.tree, q), strict=True):
        R_BP, p_BP = poses[link.parent + 1]
        poses.append((R_BP @ R_PJ, p_BP + np.einsum("nab,nb->na", R_BP, p_PJ)))
    return poses
