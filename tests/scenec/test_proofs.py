"""Proofs that there is no scene: each argument by its smallest case and by the nearest feasible one; never false."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, box

from geom.planar import turned
from scenec.check.judge_scene import violations
from scenec.ir.problem import Placement, Problem, Thing
from scenec.proofs import prove, prove_cheaply
from scenec.proofs.exhaustive import no_arrangement
from scenec.proofs.outlines import kernel, least_width, period, support_bounds
from schemas.scene.geometry import Domain, FixedPose, KeepOutVolume, PlaceLayer, ReachRing, ScenePlace, SceneRelation
from tests.support.scene.proof_problems import box_body, left_of, problem, table, thing
from tests.support.scene.random_problems import random_problem
from tests.support.scene.truth import truth

TABLE = table(1.2, 0.8)


def kind(case: Problem) -> str | None:
    proof = prove(case)
    return proof.kind if proof else None


def three(*relations: SceneRelation, place=TABLE, **how) -> Problem:
    return problem([thing(name, (0.1, 0.06), place, yaw=(-np.pi, np.pi)) for name in "abc"], relations, **how)


def crate(width_m: float, height_m: float) -> ScenePlace:
    """The inside of a receptacle with a square floor and upright walls."""
    area = box(-width_m / 2, -width_m / 2, width_m / 2, width_m / 2)
    return ScenePlace.volume("inside", (PlaceLayer(0.0, height_m, area),), area, np.zeros(3))


def test_a_circle_of_three_is_named_exactly_and_fast():
    case = three(left_of(0, "a", "b"), left_of(1, "b", "c"), left_of(2, "c", "a"))
    start = time.process_time()
    proof = prove_cheaply(case)
    assert time.process_time() - start < 0.1
    assert proof is not None
    assert proof.kind == "relation-cycle"
    assert set(proof.paths) == {("relations", 0), ("relations", 1), ("relations", 2)}
    # Three widths of 0.06 m have to fit into nothing.
    assert (proof.value, proof.bound) == (pytest.approx(0.18), pytest.approx(0.0, abs=1e-9))


def test_words_that_mean_the_same_direction_close_a_circle_too():
    right = SceneRelation("before", ("a", "b"), (-1.0, 0.0), path=("relations", 0), word="right_of")
    assert kind(three(right, left_of(1, "a", "b"))) == "relation-cycle"
    assert prove_cheaply(three(right, left_of(1, "b", "a"))) is None


def test_a_chain_wider_than_its_support_counts_gaps_and_least_widths():
    chain = left_of(0, "a", "b", 0.05), left_of(1, "b", "c", 0.05)
    assert kind(three(*chain, place=table(0.279, 0.5))) == "too-wide"
    assert kind(three(*chain, place=table(0.281, 0.5))) is None


def test_ranges_against_relations():
    west, east = thing("a", (0.1, 0.1), TABLE, x=(0.1, 0.2)), thing("b", (0.1, 0.1), TABLE, x=(-0.2, 0.1))
    proof = prove(problem([west, east], [left_of(0, "a", "b")]))
    assert proof is not None
    assert proof.kind == "too-wide"
    assert {("relations", 0), ("layout", "nodes", "a", "placement", "ranges", "x")} <= set(proof.paths)


def test_a_thing_larger_than_its_place_at_every_heading():
    assert kind(problem([thing("a", (0.3, 0.3), table(0.4, 0.29), yaw=(-np.pi, np.pi))])) == "empty-region"
    assert kind(problem([thing("a", (0.4, 0.1), table(0.36, 0.36), yaw=(-np.pi, np.pi))])) is None
    # On the diagonal a thin one fits, for (0.4 + 0.1) / sqrt(2) < 0.36; straight it does not.
    assert kind(problem([thing("a", (0.4, 0.1), table(0.35, 0.35), yaw=(-0.1, 0.1))])) == "empty-region"


def test_a_range_off_the_polygon_a_hole_a_keep_out_and_reach_leave_no_region():
    assert kind(problem([thing("a", (0.1, 0.1), TABLE, x=(0.56, 0.7))])) == "empty-region"
    holed = replace(TABLE, polygon=Polygon(TABLE.polygon.exterior, [box(-0.5, -0.3, 0.5, 0.3).exterior]))
    assert kind(problem([thing("a", (0.1, 0.1), holed, yaw=(-np.pi, np.pi))])) is None
    assert kind(problem([thing("a", (0.11, 0.11), holed, yaw=(-np.pi, np.pi))])) == "empty-region"
    keep = KeepOutVolume("background", TABLE, box(-0.5, -0.4, 0.5, 0.4), 0.1, ("keep_outs", 0))
    assert kind(problem([thing("a", (0.11, 0.11), TABLE)], keep_outs=(keep,))) == "empty-region"
    assert kind(problem([thing("a", (0.1, 0.1), TABLE)], keep_outs=(keep,))) is None
    reach = ReachRing(np.array([0.0, -1.0, 0.0]), 0.0, 0.66, ("a",), ("reach",))
    assert kind(problem([thing("a", (0.1, 0.1), TABLE)], reach=reach)) is None
    assert kind(problem([thing("a", (0.1, 0.1), TABLE, y=(-0.2, 0.2))], reach=reach)) == "empty-region"


def test_too_high_for_a_shelf_or_a_box():
    low = table(1.2, 0.8, clearance=0.2)
    assert kind(problem([thing("a", (0.1, 0.1), low, height=0.21)])) == "empty-region"
    assert kind(problem([thing("a", (0.1, 0.1), low, height=0.2)])) is None
    inside = ScenePlace.volume(
        "inside", (PlaceLayer(0.0, 0.1, box(-0.1, -0.1, 0.1, 0.1)),), box(-0.1, -0.1, 0.1, 0.1), np.zeros(3)
    )
    assert kind(problem([thing("a", (0.1, 0.1), inside, height=0.11)])) == "empty-region"


def test_more_area_than_the_support_has():
    tiles = [thing(f"t{k}", (0.1, 0.1), table(0.32, 0.32)) for k in range(9)]
    assert kind(problem(tiles, clearance=0.01)) is None
    assert kind(problem([*tiles, thing("t9", (0.1, 0.1), table(0.32, 0.32))], clearance=0.01)) == "area-bound"


def test_area_of_the_stretch_that_ranges_share():
    crowd = [thing(f"t{k}", (0.1, 0.1), TABLE, x=(0.0, 0.1), y=(0.0, 0.1)) for k in range(6)]
    assert kind(problem(crowd)) == "area-bound"


def test_things_that_may_be_stacked_are_not_counted_side_by_side():
    inside = ScenePlace.volume(
        "inside", (PlaceLayer(0.0, 0.2, box(-0.06, -0.06, 0.06, 0.06)),), box(-0.06, -0.06, 0.06, 0.06), np.zeros(3)
    )
    assert kind(problem([thing(name, (0.1, 0.1), inside, height=0.1) for name in "ab"])) is None
    assert kind(problem([thing(name, (0.1, 0.1), inside, height=0.11) for name in "ab"])) == "area-bound"


def test_near_and_far_contradict():
    pairs = (("a", "b"), ("b", "c"))
    near = [SceneRelation("near", pair, gap_m=0.05, path=("relations", k)) for k, pair in enumerate(pairs)]
    far = SceneRelation("far_from", ("a", "c"), gap_m=0.3, path=("relations", 2))
    proof = prove_cheaply(three(*near, far))
    assert proof is not None
    assert set(proof.paths) == {("relations", 0), ("relations", 1), ("relations", 2)}
    assert prove_cheaply(three(*near, replace(far, gap_m=0.1))) is None


def test_more_mugs_than_hooks():
    fixed_poses = tuple(FixedPose(0.2 * k, 0.0, 0.0, 0.0, f"s{k}") for k in range(2))
    mugs = [thing(name, (0.08, 0.08), TABLE, fixed_poses=fixed_poses) for name in "abc"]
    assert kind(problem(mugs)) == "empty-domain"
    assert kind(problem(mugs[:2])) is None
    blocked = KeepOutVolume("background", TABLE, box(0.1, -0.1, 0.3, 0.1), 0.1, ("keep_outs", 0))
    assert kind(problem(mugs[:2], keep_outs=(blocked,))) == "empty-domain"


def test_owners_in_a_circle_or_absent():
    a, b = thing("a", (0.1, 0.1), TABLE, parent="b"), thing("b", (0.1, 0.1), TABLE, parent="a")
    assert kind(problem([a, b])) == "owner-cycle"
    assert kind(problem([a])) == "missing-anchor"


def test_children_are_bounded_in_the_frame_of_their_owner():
    tray = box_body("tray", 0.3, 0.2, 0.02, holds=True)
    top = tray.surfaces[0]
    children = [thing(name, (0.1, 0.1), top, parent="tray") for name in "abc"]
    relations = [replace(left_of(k, a, b, 0.01), frame="tray") for k, (a, b) in enumerate(["ab", "bc"])]
    stands = thing("tray", tray, TABLE, yaw=(-np.pi, np.pi))
    assert kind(problem([stands, *children], relations)) == "too-wide"
    assert kind(problem([stands, *children[:2]], relations[:1])) is None


def test_two_that_exclude_each_other_are_ruled_out_by_trying_all_sides():
    both = [thing(name, (0.11, 0.11), table(0.2, 0.2)) for name in "ab"]
    assert no_arrangement(problem(both)) is not None
    assert no_arrangement(problem([thing(name, (0.09, 0.09), table(0.2, 0.2)) for name in "ab"])) is None


def test_trying_all_sides_covers_free_headings():
    both = [thing(name, (0.18, 0.1), table(0.2, 0.2), yaw=(-np.pi, np.pi)) for name in "ab"]
    assert no_arrangement(problem(both, clearance=0.01)) is not None
    assert no_arrangement(problem(both, clearance=0.0)) is None


corners = st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)), min_size=4, max_size=8)
angle = st.floats(-4.0, 4.0)


@settings(max_examples=60, deadline=None)
@given(corners, angle, st.floats(0.0, 2 * np.pi), angle, st.floats(0.0, 1.0))
def test_bounds_over_headings_hold_at_every_heading(points, low, span, aim, part):
    shape = Polygon(points).convex_hull if len(set(points)) > 3 else None
    if not isinstance(shape, Polygon) or shape.area < 1e-6:
        return
    ring = np.asarray(shape.exterior.coords)[:0:-1]
    ring = ring if Polygon(ring).exterior.is_ccw else ring[::-1]
    direction, yaw, at = np.array([np.cos(aim), np.sin(aim)]), (low, low + span), low + part * span
    along = turned(ring, at) @ direction
    front_low, front_high, back_low, back_high = support_bounds(ring, direction, yaw)
    assert front_low - 1e-12 <= along.max() <= front_high + 1e-12
    assert back_low - 1e-12 <= -along.min() <= back_high + 1e-12
    assert least_width(ring, direction, yaw) <= np.ptp(along) + 1e-12
    inner = kernel(ring, yaw)
    if len(inner) >= 3:
        assert Polygon(turned(ring, at)).buffer(1e-9).covers(Polygon(inner))


def test_symmetric_outlines_have_short_periods():
    assert period(box_body("a", 0.1, 0.1).resting_orientations[0].prisms[0].outline_m) == pytest.approx(np.pi / 2)
    assert period(box_body("a", 0.1, 0.05).resting_orientations[0].prisms[0].outline_m) == pytest.approx(np.pi)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_no_proof_against_a_scene_that_exists(seed):
    """Things are put down first, then rules that the scene keeps are written around it: nothing may be proved."""
    rng = np.random.default_rng(seed)
    placements: dict[str, Placement] = {}
    things: list[Thing] = []
    for k in range(int(rng.integers(2, 7))):
        free = bool(rng.random() < 0.5)
        item = thing(f"o{k}", tuple(rng.uniform(0.03, 0.1, 2)), table(0.3, 0.24), yaw=(-np.pi, np.pi))
        x, y, yaw = rng.uniform([-0.13, -0.1, -3.1], [0.13, 0.1, 3.1]).tolist()
        at = Placement(x, y, yaw, 0)
        if violations(problem([*things, item], clearance=0.005), placements | {item.name: at}):
            continue
        pinch = Domain((at.x_m - 0.01, at.x_m + 0.01), (at.y_m, at.y_m), (at.yaw_rad - 0.1, at.yaw_rad))
        things.append(item if free else replace(item, domain=replace(pinch, path=item.domain.path)))
        placements[item.name] = at
    relations = []
    for one in things:
        for two in things:
            relation = left_of(len(relations), one.name, two.name, 0.002)
            if one is not two and not violations(problem(things, [relation], 0.005), placements):
                relations.append(relation)
    case = problem(things, relations, 0.005)
    assert violations(case, placements) == ()
    assert prove(case, most_programs=30) is None


def test_random_programs_against_trying_everything():
    answers = [(truth(case, (0.01, 0.005)), prove(case)) for case in map(random_problem, range(16))]
    none = [proof for answer, proof in answers if answer == "no"]
    assert [proof for answer, proof in answers if answer == "yes" and proof is not None] == []
    assert len(none) >= 6
    assert sum(proof is not None for proof in none) >= 0.9 * len(none)
