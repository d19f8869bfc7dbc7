"""The independent judge: every kind of violation by its smallest scene, and the laws that a judge must obey."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import MultiPoint, Polygon, box

from scene_check import CheckObject, CheckScene, PosedPlace, check
from scene_check.batch import place_in_world
from scene_check.measures import farthest_outside, outside
from schemas.scene.geometry import (
    Domain,
    FixedPose,
    KeepOutVolume,
    PlaceLayer,
    Prism,
    ReachRing,
    ScenePlace,
    SceneRelation,
)


def posed(owner: str, place: ScenePlace) -> PosedPlace:
    """A place of an owner at the origin of W."""
    return place_in_world(owner, place, np.zeros(3), 0.0)


TOP = ScenePlace("top", box(-0.6, -0.4, 0.6, 0.4), np.zeros(3))
TABLE = posed("background", TOP)


def table(**changed) -> PosedPlace:
    """The table with a changed top."""
    return posed("background", replace(TOP, **changed))


def bowl(*layers: tuple[float, float, Polygon]) -> PosedPlace:
    """The inside of a receptacle on the background."""
    inside = tuple(PlaceLayer(*layer) for layer in layers)
    return posed("background", ScenePlace.volume("inside", inside, inside[-1].polygon, np.zeros(3)))


def block(name: str, x: float, y: float, *, size=(0.1, 0.1, 0.1), base=0.0, yaw=0.0, place=TABLE, **how) -> CheckObject:
    """A box that stands at (x, y) of a place, `base` over it."""
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * size[:2]
    floor = place.origin_m[2] + base
    origin = np.array([place.origin_m[0] + x, place.origin_m[1] + y, floor])
    prism = Prism(corners @ turn + origin[:2], floor, floor + size[2])
    return CheckObject(name, (prism,), origin, yaw, np.array([np.cos(yaw), np.sin(yaw)]), place, **how)


def kinds(*objects: CheckObject, clearance=0.01, **rules) -> list[tuple[str, tuple[str, ...]]]:
    return [(v.kind, v.names) for v in check(CheckScene(objects, clearance, **rules))]


def test_a_scene_at_its_bounds_is_valid():
    assert kinds(block("a", -0.55, 0.35), block("b", -0.44, 0.35)) == []


def test_clearance_is_measured_between_footprints():
    (found,) = check(CheckScene((block("a", 0.0, 0.0), block("b", 0.105, 0.0)), 0.01))
    assert (found.kind, found.names, found.bound) == ("clearance", ("a", "b"), 0.01)
    assert found.value == pytest.approx(0.005)


def test_the_tolerance_is_one_micrometre():
    assert kinds(block("a", 0.0, 0.0), block("b", 0.11 - 0.9e-6, 0.0)) == []
    assert kinds(block("a", 0.0, 0.0), block("b", 0.11 - 1.1e-6, 0.0)) == [("clearance", ("a", "b"))]


def test_corner_to_corner_counts_euclidean():
    apart = 0.1 + 0.01 / np.sqrt(2.0)
    assert kinds(block("a", 0.0, 0.0), block("b", apart, apart)) == []
    assert kinds(block("a", 0.0, 0.0), block("b", apart - 1e-5, apart)) == [("clearance", ("a", "b"))]


def test_overlap_is_a_penetration_with_its_depth():
    (found,) = check(CheckScene((block("a", 0.0, 0.0), block("b", 0.07, 0.01)), 0.0))
    assert found.kind == "penetration"
    assert found.value == pytest.approx(0.03)


def test_touching_is_allowed_without_clearance():
    assert kinds(block("a", 0.0, 0.0), block("b", 0.1, 0.0), clearance=0.0) == []


def test_a_footprint_over_the_edge_or_over_a_hole_is_off_the_support():
    (found,) = check(CheckScene((block("a", 0.58, 0.0),), 0.0))
    assert (found.kind, found.value) == ("off_support", pytest.approx(0.03))
    holed = table(polygon=Polygon(TOP.polygon.exterior, [box(-0.02, -0.02, 0.02, 0.02).exterior]))
    (found,) = check(CheckScene((block("a", 0.0, 0.0, place=holed),), 0.0))
    assert (found.kind, found.value) == ("off_support", pytest.approx(0.02, rel=0.02))


def test_a_shelf_above_limits_the_height():
    shelf = table(height_m=0.08)
    assert kinds(block("a", 0.0, 0.0, place=shelf)) == [("headroom", ("a", "background"))]
    assert kinds(block("a", 0.0, 0.0, size=(0.1, 0.1, 0.08), place=shelf)) == []


def test_what_stands_on_a_tray_is_held_under_the_shelf_too():
    shelf = table(height_m=0.1)
    tray = block("tray", 0.0, 0.0, size=(0.3, 0.3, 0.02), place=shelf)
    on_tray = posed("tray", ScenePlace("top", box(-0.15, -0.15, 0.15, 0.15), np.array([0.0, 0.0, 0.02])))
    assert kinds(tray, block("mug", 0.0, 0.0, place=on_tray)) == [("headroom", ("mug", "background"))]


def test_a_rim_of_the_owner_may_not_be_entered():
    rim = Prism(np.array([[0.2, -0.4], [0.25, -0.4], [0.25, 0.4], [0.2, 0.4]]), 0.0, 0.05)
    rimmed = table(above=(rim,))
    assert kinds(block("a", 0.16, 0.0, place=rimmed)) == [("owner_entered", ("a", "background"))]
    assert kinds(block("a", 0.15, 0.0, place=rimmed)) == []


def test_inside_a_volume_every_layer_counts_at_its_height():
    inside = bowl((0.0, 0.05, box(-0.06, -0.06, 0.06, 0.06)), (0.05, 0.2, box(-0.2, -0.2, 0.2, 0.2)))
    assert kinds(block("a", 0.0, 0.0, place=inside)) == []
    assert kinds(block("a", 0.02, 0.0, place=inside)) == [("outside_volume", ("a", "background"))]
    assert kinds(block("a", 0.0, 0.0, size=(0.1, 0.1, 0.21), place=inside)) == [("headroom", ("a", "background"))]


def test_stacked_contents_need_something_under_their_middle():
    inside = bowl((0.0, 0.5, TOP.polygon))
    low = block("low", 0.0, 0.0, place=inside)
    assert kinds(low, block("high", 0.02, 0.0, base=0.1, place=inside)) == []
    assert kinds(low, block("high", 0.06, 0.0, base=0.1, place=inside)) == [("unsupported", ("high", "background"))]
    assert kinds(low, block("high", 0.02, 0.0, base=0.11, place=inside)) == [("unsupported", ("high", "background"))]


def test_a_pile_stays_whatever_its_parts_weigh():
    """Of three blocks each has its middle over the one below, but the highest presses beyond where the second is held,
    and would tip it if heavy; a block on two needs both; a ball touches in a point and holds nothing."""
    inside = bowl((0.0, 0.5, TOP.polygon))

    def at(name: str, x: float, level: int, width: float = 0.1) -> CheckObject:
        return block(name, x, 0.0, base=0.1 * level, size=(width, 0.1, 0.1), place=inside)

    assert kinds(at("a", 0.0, 0), at("b", 0.03, 1), at("c", 0.03, 2)) == []
    assert kinds(at("a", 0.0, 0), at("b", 0.03, 1), at("c", 0.06, 2)) == [("unsupported", ("b", "background"))]
    bridged = [at("a", -0.07, 0), at("b", 0.07, 0), at("c", 0.0, 1, 0.2)]
    assert kinds(*bridged) == []
    assert kinds(*bridged[1:]) == [("unsupported", ("c", "background"))]
    tip = Prism(np.array([[-0.004, -0.004], [0.004, -0.004], [0.004, 0.004], [-0.004, 0.004]]), 0.0, 0.0005)
    body = Prism(tip.outline_m * 12.5, 0.0005, 0.0995)
    ball = replace(at("ball", 0.0, 0), prisms=(tip, body, replace(tip, low_m=0.0995, high_m=0.1)))
    assert kinds(ball) == []
    assert kinds(ball, at("b", 0.0, 1)) == [("unsupported", ("b", "background"))]


def test_siblings_are_judged_by_whole_footprints_and_others_by_prisms():
    lamp = block("lamp", 0.0, 0.0, size=(0.05, 0.05, 0.3))
    shade = Prism(np.array([[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]), 0.2, 0.3)
    lamp = replace(lamp, prisms=(*lamp.prisms, shade))
    mug = block("mug", 0.12, 0.0)
    assert kinds(lamp, mug) == [("clearance", ("lamp", "mug"))]
    elsewhere = table(name="other")
    assert kinds(lamp, block("mug", 0.12, 0.0, place=elsewhere)) == []
    assert kinds(lamp, block("pole", 0.12, 0.0, size=(0.1, 0.1, 0.25), place=elsewhere)) == [
        ("penetration", ("lamp", "pole"))
    ]


def test_things_over_each_other_in_height_do_not_meet():
    upper = table(name="upper", origin_P_m=np.array([0.0, 0.0, 0.5]))
    assert kinds(block("a", 0.0, 0.0), block("b", 0.0, 0.0, place=upper)) == []


def test_ranges_spots_and_stances():
    assert kinds(block("a", 0.1, 0.0, yaw=np.pi - 0.1, domain=Domain(x_m=(0.1, 0.2), yaw_rad=(3.0, 3.2)))) == []
    assert kinds(block("a", 0.1, 0.0, yaw=-np.pi + 0.05, domain=Domain(yaw_rad=(3.0, 3.3)))) == []
    assert kinds(block("a", 0.1, 0.0, yaw=0.5, domain=Domain(yaw_rad=(-0.4, 0.4)))) == [("range", ("a",))]
    assert kinds(block("a", 0.05, 0.0, domain=Domain(x_m=(0.1, 0.2)))) == [("range", ("a",))]
    assert kinds(block("a", 0.1, 0.0, domain=Domain(fixed_poses=(FixedPose(0.1, 0.0, 0.0, 2 * np.pi),)))) == []
    assert kinds(block("a", 0.1, 0.0, domain=Domain(fixed_poses=(FixedPose(0.1, 0.01, 0.0, 0.0),)))) == [
        ("spot", ("a",))
    ]
    assert kinds(block("a", 0.1, 0.0, stance=2, domain=Domain(orientation_indices=(0, 1)))) == [("stance", ("a",))]


@pytest.mark.parametrize(
    ("kind", "holds", "gap", "tolerance"),
    [
        ("before", False, 0.11, 0.0),
        ("before", True, 0.1, 0.0),
        ("near", True, 0.1, 0.0),
        ("near", False, 0.09, 0.0),
        ("far_from", True, 0.1, 0.0),
        ("far_from", False, 0.11, 0.0),
        ("aligned", True, 0.0, 0.0),
        ("facing", True, 0.0, 0.0),
    ],
)
def test_relations_between_two_blocks_a_decimetre_apart(kind, holds, gap, tolerance):
    relation = SceneRelation(kind, ("a", "b"), (1.0, 0.0), gap, tolerance)
    assert (kinds(block("a", -0.1, 0.0), block("b", 0.1, 0.0), relations=(relation,)) == []) == holds


def test_between_facing_and_aligned_tell_when_they_are_broken():
    three = block("m", 0.0, 0.02), block("l", -0.2, 0.0), block("r", 0.2, 0.0)
    for kind, names, tolerance, holds in [
        ("between", ("m", "l", "r"), 0.02, True),
        ("between", ("m", "l", "r"), 0.019, False),
        ("between", ("l", "m", "r"), 0.5, False),
        ("aligned", ("m", "l", "r"), 0.02, True),
        ("aligned", ("m", "l", "r"), 0.01, False),
        ("facing", ("r", "l"), 0.1, False),
    ]:
        relation = SceneRelation(kind, names, (1.0, 0.0), 0.0, tolerance)
        assert (kinds(*three, relations=(relation,)) == []) == holds, (kind, names, tolerance)


def test_keep_outs_and_reach():
    keep = TABLE, KeepOutVolume("background", TOP, box(0.2, -0.4, 0.6, 0.4), 0.05)
    assert kinds(block("a", 0.15, 0.0), keep_outs=(keep,)) == []
    assert kinds(block("a", 0.16, 0.0), keep_outs=(keep,)) == [("keep_out", ("a",))]
    ring = ReachRing(np.array([0.0, -0.5, 0.3]), 0.3, 0.6, ("a",))
    assert kinds(block("a", 0.0, 0.1), reach=ring) == []
    assert kinds(block("a", 0.0, 0.2), reach=ring) == [("reach", ("a",))]
    assert kinds(block("a", 0.0, -0.25), reach=ring) == [("reach", ("a",))]


pose = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.3, 0.3), st.floats(-3.0, 3.0))


def crowd(poses) -> CheckScene:
    objects = tuple(block(f"o{k}", x, y, yaw=yaw) for k, (x, y, yaw) in enumerate(poses))
    relation = SceneRelation("before", ("o0", "o1"), (1.0, 0.0), 0.01)
    return CheckScene(objects, 0.01, (relation,))


@settings(max_examples=40, deadline=None)
@given(st.lists(pose, min_size=2, max_size=6), st.randoms(use_true_random=False))
def test_the_order_of_objects_does_not_matter(poses, random):
    scene = crowd(poses)
    shuffled = list(scene.objects)
    random.shuffle(shuffled)
    again = check(replace(scene, objects=tuple(shuffled)))
    assert {(v.kind, frozenset(v.names)) for v in again} == {(v.kind, frozenset(v.names)) for v in check(scene)}


def moved_point(points, turn, shift):
    return points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) + shift


@settings(max_examples=40, deadline=None)
@given(st.lists(pose, min_size=2, max_size=6), st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_a_rigid_motion_of_the_whole_scene_changes_no_verdict(poses, turn, dx, dy):
    scene, shift = crowd(poses), np.array([dx, dy])
    place = replace(TABLE, origin_m=np.array([dx, dy, 0.0]), yaw_rad=turn)
    objects = tuple(
        replace(
            item,
            prisms=tuple(replace(p, outline_m=moved_point(p.outline_m, turn, shift)) for p in item.prisms),
            origin_m=np.array([*moved_point(item.origin_m[None, :2], turn, shift)[0], item.origin_m[2]]),
            yaw_rad=item.yaw_rad + turn,
            front=moved_point(item.front[None], turn, 0.0)[0],
            place=place,
        )
        for item in scene.objects
    )
    direction = moved_point(np.array([scene.relations[0].direction]), turn, 0.0)[0]
    relation = replace(scene.relations[0], direction=tuple(direction.tolist()))
    before = check(scene)
    after = check(replace(scene, objects=objects, relations=(relation,)))
    assert [(v.kind, v.names) for v in after] == [(v.kind, v.names) for v in before]
    assert [v.value for v in after] == pytest.approx([v.value for v in before], rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("seed", range(30))
def test_outlines_together_stick_out_as_far_as_the_worst_of_them(seed: int):
    rng = np.random.default_rng(seed)
    west, south, east, north = np.sort(rng.uniform(-0.3, 0.3, (2, 2)), axis=0).reshape(-1).tolist()
    place = Polygon(box(-0.5, -0.4, 0.5, 0.4).exterior, [box(west, south, east, north).exterior])
    clouds = [rng.uniform(-0.15, 0.15, (6, 2)) + rng.uniform(-0.4, 0.4, 2) for _ in range(4)]
    outlines = [np.array(shapely.get_coordinates(MultiPoint(cloud).convex_hull)[:-1]) for cloud in clouds]
    for some in (outlines, outlines[:1], []):
        assert farthest_outside(some, place) == max((outside(one, place) for one in some), default=0.0)
