"""The exercise of joints in PyBullet: closed forms, the traps that the files name, and the same at every size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pybullet
import pytest

from geom.convex.placement import moved_shape
from geom.mechanism_pose import joint_positions, link_motions
from geom.pose import pose
from schemas.arrays import FloatArray
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismLink
from schemas.physics import CollisionShape, MassProperties, RigidBody
from sim.bullet.articulation import build
from sim.bullet.joint_exercise import BEYOND, exercise_joints
from sim.bullet.world import private_client
from sim.joint_exercise import Articulation, JointExercise, JointTask, moved_links, reach_of
from tests.support.sample_bodies import boxes

Z = np.array([0.0, 0.0, 1.0])


def block(name: str, size_m: tuple[float, float, float], at: FloatArray) -> tuple[RigidBody, MechanismLink]:
    """A box about the origin of its link."""
    body = boxes([(size_m, (0.0, 0.0, 0.0))])
    return replace(body, name=name), MechanismLink(name, np.asarray(at, dtype=np.float64))


def arm(scale: float = 1.0, **changes: object) -> Articulation:
    """A post, an arm of 0.4 m turning level about its end, and a weight that slides along the arm."""
    s = scale
    parts = [
        block("post", (0.1 * s, 0.1 * s, 0.3 * s), np.array([0.0, 0.0, 0.15 * s])),
        block("arm", (0.4 * s, 0.05 * s, 0.04 * s), np.array([0.25 * s, 0.0, 0.35 * s])),
        block("weight", (0.05 * s, 0.05 * s, 0.05 * s), np.array([0.1 * s, 0.0, 0.41 * s])),
    ]
    turn = MechanismJoint(
        "turn", "revolute", "post", "arm", np.array([0.05 * s, 0.0, 0.35 * s]), Z, limits=(-0.5, 1.2), rest=0.2
    )
    slide = MechanismJoint(
        "slide", "prismatic", "arm", "weight", parts[2][1].origin, np.array([1.0, 0.0, 0.0]), limits=(0.0, 0.3 * s)
    )
    turn = replace(turn, **changes)
    return Articulation(Mechanism(tuple(link for _, link in parts), (turn, slide)), tuple(body for body, _ in parts))


def exercise(articulation: Articulation, *joints: str, probe: CollisionShape | None = None) -> list[JointExercise]:
    origins = {link.name: link.origin for link in articulation.mechanism.links}
    by_name = {joint.name: joint for joint in articulation.mechanism.joints}
    tasks = [JointTask(name, origins[by_name[name].child] + np.array([0.0, 0.02, 0.0]), probe) for name in joints]
    return list(exercise_joints(articulation, tasks).joints)


@pytest.mark.parametrize("scale", [0.01, 1.0, 30.0])
def test_joints_reach_their_limits_and_stop_there_at_every_size(scale: float) -> None:
    turn, slide = exercise(arm(scale), "turn", "slide")
    for result, (low, high) in ((turn, (-0.5, 1.2)), (slide, (0.0, 0.3 * scale))):
        span = high - low
        assert result.reach == pytest.approx((low, high))
        assert [(run.actuation, run.pace) for run in result.runs] == list(JointTask("", Z).runs)
        for run in result.runs:
            assert run.finite
            assert run.lowest == pytest.approx(low, abs=0.5 * BEYOND * span + run.step)
            assert run.highest == pytest.approx(high, abs=0.5 * BEYOND * span + run.step)
            assert run.left_rest <= 0.002 * span
            assert run.speed_mps <= run.bound_mps
    assert turn.axis == pytest.approx(Z, abs=1e-5)
    assert slide.axis == pytest.approx([1.0, 0.0, 0.0], abs=1e-5)


def test_a_joint_without_limits_makes_one_turn_and_is_not_stopped() -> None:
    (turn,) = exercise(arm(kind="continuous", limits=None), "turn")
    assert turn.reach == pytest.approx((0.2, 0.2 + 2.0 * np.pi))
    assert all(run.highest >= turn.reach[1] - 0.02 for run in turn.runs)


@pytest.mark.parametrize("damping", [0.0, 0.1, 1e3])
def test_damping_far_above_the_inertia_does_not_explode(damping: float) -> None:
    """1e3 N m s on 0.1 kg m2 at steps of 4 ms: the engine's own damping would multiply the rate by -40."""
    (turn,) = exercise(arm(damping=damping), "turn")
    assert all(run.finite and run.speed_mps <= run.bound_mps for run in turn.runs)
    assert min(run.highest for run in turn.runs) == pytest.approx(1.2, abs=0.04)


def test_an_inertia_beyond_all_mass_at_the_far_end_cannot_be_moved() -> None:
    heavy = arm()
    mass = heavy.links[1].mass
    body = replace(heavy.links[1], mass=MassProperties(mass.mass_kg, mass.centre_of_mass_m, 1e4 * mass.inertia_kgm2))
    (turn,) = exercise(replace(heavy, links=(heavy.links[0], body, heavy.links[2])), "turn")
    assert max(run.highest for run in turn.runs) < 1.0


def test_a_block_of_another_link_stops_a_joint_and_is_named() -> None:
    """A gate at the far side of the swing, on a joint of its own: it collides, and others could move it away."""
    plain = arm()
    gate, link = block("gate", (0.1, 0.1, 0.1), np.array([0.3, 0.3, 0.35]))
    joint = MechanismJoint("lift", "prismatic", "post", "gate", link.origin, Z, limits=(0.0, 0.2))
    mechanism = replace(plain.mechanism, links=(*plain.mechanism.links, link), joints=(*plain.mechanism.joints, joint))
    blocked = Articulation(mechanism, (*plain.links, gate))
    (turn,) = exercise(blocked, "turn")
    assert max(run.highest for run in turn.runs) < 1.0
    assert {turn.overlaps[0].first, turn.overlaps[0].second} == {"arm", "gate"}
    assert (turn.overlaps[0].collides, turn.overlaps[0].fixed) == (True, False)
    filtered = replace(blocked, filtered_pairs=(("gate", "arm"),))
    (free,) = exercise(filtered, "turn")
    assert min(run.highest for run in free.runs) == pytest.approx(1.2, abs=0.04)
    assert not free.overlaps[0].collides


def test_what_lies_in_a_link_is_carried_and_what_lies_beside_it_is_not() -> None:
    """A cube on the tray comes along for 0.3 m; without the tray's collision shapes it falls."""
    size = np.array([0.3, 0.2, 0.02])
    tray, link = block("tray", tuple(size), np.array([0.0, 0.0, 0.3]))
    base, base_link = block("base", (0.1, 0.1, 0.1), np.array([0.0, 0.0, 0.05]))
    slide = MechanismJoint(
        "slide", "prismatic", "base", "tray", link.origin, np.array([1.0, 0.0, 0.0]), limits=(0.0, 0.3)
    )
    table = Articulation(Mechanism((base_link, link), (slide,)), (base, tray))
    cube = CollisionShape("box", (0.04, 0.04, 0.04), pose(None, (0.0, 0.0, 0.332)))
    (carried,) = exercise(table, "slide", probe=cube)
    assert carried.probe is not None
    assert carried.probe.moved_m == pytest.approx(0.3, abs=0.005)
    assert np.linalg.norm(carried.probe.end - carried.probe.start) < 0.02
    raised = replace(tray, shapes=tuple(moved_shape(s, pose(None, (0.0, 0.5, 0.0))) for s in tray.shapes))
    (left,) = exercise(replace(table, links=(base, raised)), "slide", probe=cube)
    assert left.probe is not None
    assert np.linalg.norm(left.probe.end - left.probe.start) > 0.2


def test_joints_that_follow_move_with_their_leader_and_narrow_its_reach() -> None:
    plain = arm()
    turn, slide = plain.mechanism.joints
    follow = replace(slide, coupling=JointCoupling("turn", 0.5, -0.1))  # 0 at 0.2 rad, 0.3 at 0.8 rad
    coupled = replace(plain, mechanism=replace(plain.mechanism, joints=(turn, follow)))
    assert reach_of(coupled.mechanism, turn) == pytest.approx((0.2, 0.8))
    (result,) = exercise(coupled, "turn")
    assert min(run.highest for run in result.runs) >= 0.8 - 0.01


def test_links_of_a_branched_mechanism_stand_where_the_kinematics_put_them() -> None:
    """The engine numbers links depth first: with the links listed breadth first they would be mixed up."""
    links, joints, bodies = [], [], []
    for name, parent, at in (
        ("root", "", (0.0, 0.0, 0.0)),
        ("a", "root", (0.3, 0.0, 0.0)),
        ("b", "root", (-0.3, 0.1, 0.0)),
        ("a_tip", "a", (0.6, 0.0, 0.1)),
        ("b_tip", "b", (-0.6, 0.1, 0.2)),
    ):
        body, link = block(name, (0.1, 0.05, 0.04), np.array(at))
        links.append(link)
        bodies.append(body)
        if parent:
            axis = np.array([0.0, 0.6, 0.8]) if parent == "root" else Z
            joints.append(
                MechanismJoint(f"j_{name}", "revolute", parent, name, link.origin - 0.02, axis, limits=(-2.0, 2.0))
            )
    articulation = Articulation(Mechanism(tuple(links), tuple(joints)), tuple(bodies))
    positions = {"j_a": 0.7, "j_b": -1.1, "j_a_tip": 0.4, "j_b_tip": 1.3}
    with private_client() as client:
        built = build(articulation, client)
        built.set_positions(joint_positions(articulation.mechanism, positions))
        motions = link_motions(articulation.mechanism, positions)
        for name in motions:
            assert built.link_pose(name) == pytest.approx(motions[name] @ built.X_AL[name], abs=1e-6)
        masses = [
            pybullet.getDynamicsInfo(built.handle, built.index[b.name], physicsClientId=client)[0] for b in bodies
        ]
    assert masses[1:] == pytest.approx([b.mass.mass_kg for b in bodies[1:]])
    assert moved_links(articulation.mechanism, joints[:1]) == {"a", "a_tip"}


def test_equal_calls_give_equal_results() -> None:
    assert str(exercise(arm(), "turn", "slide")) == str(exercise(arm(), "turn", "slide"))
