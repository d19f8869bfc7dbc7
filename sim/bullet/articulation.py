"""An articulated object in PyBullet: a multibody with a fixed base, built from the bodies of its links, at rest.

Positions of the engine's joints are 0 at rest. Everything is simulated at `scale` times its true size
(`sim.port.model_scale`): lengths x s, times x sqrt(s), masses x s^3, inertias x s^5.

Traps of PyBullet 3.2.7, beside those that `sim.bullet.simulator` lists, each covered by a test:
- joint damping is integrated explicitly and blows up where damping x step exceeds the inertia: it is left at 0;
- with self-collision on, links that a joint connects collide too: pairs are filtered one by one;
- a limit holds with at most 100 N s per step unless `jointLimitForce` says otherwise: heavy links run through;
- links are numbered depth first, whatever order they are given in;
- a joint turns about the origin of the frame of its child: links are built in frames that lie on their axes.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from geom import pose
from geom.convex.placement import moved_shape
from geom.convex.support_function import diagonal
from geom.mass.principal_axes import principal_axes
from schemas.arrays import FloatArray
from schemas.mechanism import Mechanism, MechanismJoint
from schemas.physical_constants import GRAVITY_MPS2
from sim.bullet.shapes import clear_margins, compound
from sim.bullet.world import scaled
from sim.joint_exercise import Articulation
from sim.port import model_scale

JOINT_STEP_S = 1.0 / 240.0  # of the engine, at model size
ITERATIONS = 100  # of the solver: motors, limits and contacts of one chain work against each other
_KINDS: Mapping[str, int] = {
    "revolute": pybullet.JOINT_REVOLUTE,
    "continuous": pybullet.JOINT_REVOLUTE,
    "prismatic": pybullet.JOINT_PRISMATIC,
    "ball": pybullet.JOINT_FIXED,  # Not exercised: held at rest.
}


@dataclass(frozen=True)
class BuiltArticulation:
    """The multibody in a private world, and what the exercise needs of it.

    `index` is the engine's number of each link but the root (-1), by name; the joint that carries a link has the same.
    `X_AL` are the frames in which links are built, at rest, in the frame of the object, at true size.
    """

    articulation: Articulation
    client: int
    handle: int
    scale: float
    index: Mapping[str, int]
    X_AL: Mapping[str, FloatArray]

    def joint_index(self, joint: MechanismJoint) -> int:
        """The engine's number of a joint of the tree."""
        return self.index[joint.child]

    def unit(self, joint: MechanismJoint) -> float:
        """Positions in the model per true position."""
        return 1.0 if joint.is_angular else self.scale

    def set_positions(self, positions: Mapping[str, float]) -> None:
        """Put all joints at true positions, at rest."""
        for joint in self.articulation.mechanism.tree:
            if joint.kind != "ball":
                q = (positions[joint.name] - joint.rest) * self.unit(joint)
                pybullet.resetJointState(self.handle, self.joint_index(joint), q, 0.0, physicsClientId=self.client)

    def state(self, joint: MechanismJoint) -> tuple[float, float]:
        """True position, and rate of the model."""
        q, qd, *_ = pybullet.getJointState(self.handle, self.joint_index(joint), physicsClientId=self.client)
        return q / self.unit(joint) + joint.rest, qd

    def link_pose(self, link: str) -> FloatArray:
        """X_WL (4, 4) of the frame in which a link is built, lengths of the model."""
        if self.index[link] < 0:
            return scaled(self.X_AL[link], self.scale)
        state = pybullet.getLinkState(
            self.handle, self.index[link], computeForwardKinematics=1, physicsClientId=self.client
        )
        return pose.pose(Rotation.from_quat(state[5]).as_matrix(), np.asarray(state[4]))

    def effective_inertia(self, joint: MechanismJoint) -> float:
        """Inertia (model) that a joint alone has to move now: kg or kg m2."""
        moving = [j for j in self.articulation.mechanism.tree if j.kind != "ball"]
        q = {self.joint_index(j): (self.state(j)[0] - j.rest) * self.unit(j) for j in moving}
        order = sorted(q)
        matrix = pybullet.calculateMassMatrix(self.handle, [q[i] for i in order], physicsClientId=self.client)
        return float(np.asarray(matrix)[order.index(self.joint_index(joint))][order.index(self.joint_index(joint))])

    def overlap(self, first: str, second: str) -> float:
        """How deep (true m) two links reach into each other now; filtered pairs, too."""
        a, b = self.index[first], self.index[second]
        points = pybullet.getClosestPoints(self.handle, self.handle, 0.0, a, b, physicsClientId=self.client)
        return max((-point[8] for point in points), default=0.0) / self.scale

    def pairs(self) -> Iterator[tuple[str, str, bool]]:
        """All pairs of links that have shapes, and whether they collide."""
        silent = self.articulation.silent_pairs
        shaped = [body.name for body in self.articulation.links if body.shapes]
        for first, second in combinations(shaped, 2):
            yield first, second, frozenset((first, second)) not in silent


def build(articulation: Articulation, client: int) -> BuiltArticulation:
    """The object in the empty world of `client`, its base fixed at the origin, gravity along -z, motors off."""
    mechanism = articulation.mechanism
    carrier = {joint.child: joint for joint in mechanism.tree}
    X_AL = {
        link.name: pose.pose(None, carrier[link.name].anchor if link.name in carrier else link.origin)
        for link in mechanism.links
    }
    origins = {link.name: pose.pose(None, link.origin) for link in mechanism.links}
    at_rest = [moved_shape(shape, origins[body.name]) for body in articulation.links for shape in body.shapes]
    scale = model_scale(diagonal(at_rest))
    names = _depth_first(mechanism)
    by_name = {body.name: body for body in articulation.links}
    bodies = [by_name[name] for name in names]
    index = {name: number - 1 for number, name in enumerate(names)}
    pybullet.setPhysicsEngineParameter(
        fixedTimeStep=JOINT_STEP_S,
        numSolverIterations=ITERATIONS,
        enableFileCaching=0,
        deterministicOverlappingPairs=1,
        physicsClientId=client,
    )
    pybullet.setGravity(0.0, 0.0, -GRAVITY_MPS2, physicsClientId=client)
    shapes, masses, frames = list[int](), list[float](), list[tuple[FloatArray, FloatArray]]()
    with tempfile.TemporaryDirectory() as folder:
        for body in bodies:
            X_LB = pose.inverse(X_AL[body.name]) @ origins[body.name]
            place = Path(folder) / str(len(shapes))
            place.mkdir()
            moved = [moved_shape(shape, X_LB) for shape in body.shapes]
            shape = compound(moved, scale, place, client) if moved else -1
            if moved:
                clear_margins(shape, len(moved), client)
            shapes.append(shape)
            moments, quat_wxyz = principal_axes(body.mass.inertia_kgm2)
            centre = X_LB[:3, 3] + np.asarray(body.mass.centre_of_mass_m)
            frames.append((pose.pose_from_quat(quat_wxyz, scale * centre), moments * scale**5))
            masses.append(body.mass.mass_kg * scale**3)
        X_PL = [
            scaled(pose.inverse(X_AL[carrier[n].parent]) @ X_AL[n] if n in carrier else X_AL[n], scale) for n in names
        ]
        handle = pybullet.createMultiBody(
            baseMass=0.0,
            baseCollisionShapeIndex=shapes[0],
            basePosition=X_PL[0][:3, 3].tolist(),
            linkMasses=masses[1:],
            linkCollisionShapeIndices=shapes[1:],
            linkVisualShapeIndices=[-1] * len(names[1:]),
            linkPositions=[X[:3, 3].tolist() for X in X_PL[1:]],
            linkOrientations=[[0.0, 0.0, 0.0, 1.0]] * len(names[1:]),
            linkInertialFramePositions=[X[:3, 3].tolist() for X, _ in frames[1:]],
            linkInertialFrameOrientations=[Rotation.from_matrix(X[:3, :3]).as_quat().tolist() for X, _ in frames[1:]],
            linkParentIndices=[index[carrier[n].parent] + 1 for n in names[1:]],
            linkJointTypes=[_KINDS[carrier[n].kind] for n in names[1:]],
            linkJointAxis=[np.asarray(carrier[n].axis).tolist() for n in names[1:]],
            flags=pybullet.URDF_USE_SELF_COLLISION,
            physicsClientId=client,
        )
    built = BuiltArticulation(articulation, client, handle, scale, index, X_AL)
    _set_dynamics(built, [moments for _, moments in frames])
    return built


def _depth_first(mechanism: Mechanism) -> list[str]:
    """Names of links, each followed by all that it carries: the order in which the engine numbers them."""
    below: dict[str, list[str]] = {}
    for joint in mechanism.tree:
        below.setdefault(joint.parent, []).append(joint.child)
    order, waiting = list[str](), [mechanism.root.name]
    while waiting:
        order.append(waiting.pop())
        waiting += reversed(below.get(order[-1], []))
    return order


def _set_dynamics(built: BuiltArticulation, moments: list[FloatArray]) -> None:
    client, handle = built.client, built.handle
    # These turn a whole call to the base, whatever link it names.
    damping = {"linearDamping": 0.0, "angularDamping": 0.0, "maxJointVelocity": 1e6}
    awake = pybullet.ACTIVATION_STATE_DISABLE_SLEEPING
    pybullet.changeDynamics(handle, -1, **damping, activationState=awake, physicsClientId=client)
    for number, values in enumerate(moments[1:]):
        pybullet.changeDynamics(
            handle, number, localInertiaDiagonal=values.tolist(), jointDamping=0.0, physicsClientId=client
        )
    for body in built.articulation.links:
        friction = body.contact.dynamic_friction
        pybullet.changeDynamics(
            handle, built.index[body.name], lateralFriction=math.sqrt(max(friction, 0.0)), physicsClientId=client
        )
    for joint in built.articulation.mechanism.tree:
        number = built.joint_index(joint)
        if joint.limits is not None and joint.kind != "ball":
            low, high = ((limit - joint.rest) * built.unit(joint) for limit in joint.limits)
            limits = {
                "jointLowerLimit": low,
                "jointUpperLimit": high,
                "jointLimitForce": 1e12,
                "physicsClientId": client,
            }
            pybullet.changeDynamics(handle, number, **limits)
        if joint.kind != "ball":
            pybullet.setJointMotorControl2(handle, number, pybullet.VELOCITY_CONTROL, force=0.0, physicsClientId=client)
    for first, second, collides in built.pairs():
        a, b = built.index[first], built.index[second]
        pybullet.setCollisionFilterPair(handle, handle, a, b, int(collides), physicsClientId=client)
