"""The judge's predicates of heights, angles and lines: cases that just hold and just do not, and bounds never above."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import box

from scene_check import CheckObject, CheckScene, check
from scene_check.batch import BatchPoses, SceneRules, ThingRule, place_in_world, scene_at
from scene_check.check_batch import unproven
from schemas.scene.geometry import Prism, ScenePlace, SceneRelation, Stance

X, Y = (1.0, 0.0), (0.0, 1.0)
TURN = 2.0 * np.pi
OUTLINE = np.array([(-0.01, -0.01), (0.01, -0.01), (0.01, 0.01), (-0.01, 0.01)])
TOP = ScenePlace("top", box(-1.0, -1.0, 1.0, 1.0), np.zeros(3))


def block(name: str, x: float, y: float, base: float = 0.0, height: float = 0.1) -> CheckObject:
    """A small box with its base at this height, on a place of its own height."""
    place = place_in_world("background", ScenePlace(name, TOP.polygon, np.array([0.0, 0.0, base])), np.zeros(3), 0.0)
    prism = Prism(OUTLINE + np.array([x, y]), base, base + height)
    return CheckObject(name, (prism,), np.array([x, y, base]), 0.0, np.array(X), place)


def holds(relation: SceneRelation, *objects: CheckObject) -> bool:
    violations = check(CheckScene(objects, 0.0, (relation,)))
    assert {violation.kind for violation in violations} <= {"relation"}
    return not violations


def around(*degrees: float, radius: float = 0.2) -> list[CheckObject]:
    """A centre with blocks at these angles."""
    points = radius * np.array([(np.cos(a), np.sin(a)) for a in np.radians(degrees)])
    return [block("centre", 0.0, 0.0), *(block(f"o{k}", *point) for k, point in enumerate(points))]


@pytest.mark.parametrize(
    ("rise", "gap", "expected"),
    [
        (0.05, 0.05, True),
        (0.05, 0.05 + 2e-6, False),
        (0.05, 0.05 + 0.5e-6, True),
        (0.0, 0.0, True),
        (-2e-6, 0.0, False),
    ],
)
def test_above_measures_from_the_highest_to_the_lowest_point(rise: float, gap: float, expected: bool) -> None:
    upper, lower = block("a", 0.3, 0.0, 0.1 + rise), block("b", -0.3, 0.0)
    assert holds(SceneRelation("above", ("a", "b"), X, gap), upper, lower) == expected
    assert not holds(SceneRelation("above", ("b", "a"), X, 0.0), upper, lower)


def test_above_gives_the_rise_and_its_bound() -> None:
    (violation,) = check(
        CheckScene(
            (block("a", 0.3, 0.0, 0.12), block("b", 0.0, 0.0)), 0.0, (SceneRelation("above", ("a", "b"), X, 0.05),)
        )
    )
    assert (violation.value, violation.bound, violation.unit) == (pytest.approx(0.02), 0.05, "m")


@pytest.mark.parametrize(
    ("degrees", "least", "most", "expected"),
    [
        ((0, 120, 240), 119.99, 120.01, True),
        ((0, 120, 240), 120.01, 360, False),
        ((240, 0, 120), 119.99, 360, True),
        ((10, 100, 190), 90, 180, True),
        ((10, 100, 190), 90, 179.99, False),
        ((10, 100, 190), 90.01, 360, False),
        ((-175, 175, 0), 9.99, 175.01, True),
        ((-175, 175, 0), 10.01, 360, False),
    ],
)
def test_surrounding_counts_the_angles_between_neighbours(degrees, least: float, most: float, expected: bool) -> None:
    objects = around(*degrees)
    names = tuple(item.name for item in objects)
    angle = (float(np.radians(least)), float(np.radians(most)))
    assert holds(SceneRelation("surrounding", names, X, angle_rad=angle), *objects) == expected


def test_what_lies_on_the_centre_has_no_direction() -> None:
    objects = [block("c", 0.0, 0.0), block("a", 0.2, 0.0), block("b", 0.0, 0.0, 0.2)]
    assert not holds(SceneRelation("surrounding", ("c", "a", "b"), X, angle_rad=(0.0, TURN)), *objects)


@pytest.mark.parametrize(
    ("points", "direction", "spacing", "tolerance", "expected"),
    [
        (((0, 0), (0.1, 0.01), (0.25, 0)), X, 0.0, 0.01, True),
        (((0, 0), (0.1, 0.0101), (0.25, 0)), X, 0.0, 0.01, False),
        (((0, 0), (0.25, 0), (0.1, 0)), X, 0.0, 0.01, False),
        (((0, 0), (0.1, 0), (0.21, 0)), X, 0.1, 0.01, True),
        (((0, 0), (0.1, 0), (0.2101, 0)), X, 0.1, 0.01, False),
        (((0, 0), (0.1, 0), (0.19, 0)), X, 0.1, 0.01, True),
        (((0, 0), (0, 0.1), (0.01, 0.2)), Y, 0.1, 0.01, True),
        (((0, 0.2), (0, 0.1), (0, 0)), Y, 0.1, 0.01, False),
        (((0, 0.2), (0, 0.1), (0, 0)), (0.0, -1.0), 0.1, 0.01, True),
    ],
)
def test_in_line_counts_steps_along_and_offsets_across(points, direction, spacing, tolerance, expected) -> None:
    objects = [block(f"o{k}", x, y) for k, (x, y) in enumerate(points)]
    relation = SceneRelation("in_line", ("o0", "o1", "o2"), direction, spacing, tolerance)
    assert holds(relation, *objects) == expected


RULES = (
    SceneRelation("above", ("o3", "o0"), X, gap_m=0.05),
    SceneRelation("above", ("o3", "o1"), X, gap_m=0.1),
    SceneRelation("surrounding", ("o0", "o1", "o2", "o3"), X, angle_rad=(0.5, TURN)),
    SceneRelation("surrounding", ("o3", "o1", "o2"), X, angle_rad=(0.2, 5.8)),
    SceneRelation("in_line", ("o1", "o0", "o2"), X, tolerance=0.05),
    SceneRelation("in_line", ("o1", "o0", "o2"), X, gap_m=0.3, tolerance=0.05),
)


@pytest.mark.parametrize("rule", RULES, ids=str)
def test_bounds_of_many_scenes_hold_only_where_each_scene_does(rule: SceneRelation) -> None:
    n, rng = 400, np.random.default_rng(3)
    form = ((0, Stance((1.0, 0.0, 0.0, 0.0), (Prism(OUTLINE, 0.0, 0.1),), 0.0)),)
    places = [ScenePlace(f"p{k}", TOP.polygon, np.array([0.0, 0.0, z])) for k, z in enumerate((0.0, 0.0, 0.0, 0.2))]
    things = tuple(ThingRule(f"o{k}", form, "background", place) for k, place in enumerate(places))
    rules = SceneRules(things, np.zeros(3), 0.0, 0.0, (rule,))
    spots = np.array([(0.0, 0.0), (-0.3, 0.0), (0.3, 0.02), (0.1, 0.3)])
    at = spots + 0.1 * rng.choice([0.0, 1e-5, 1.0], size=(n, 4, 1)) * rng.uniform(-1, 1, (n, 4, 2))
    heights = np.broadcast_to([0.0, 0.0, 0.0, 0.2], (n, 4))
    origins = np.concatenate([at, heights[..., None]], axis=-1)
    poses = BatchPoses(origins, np.zeros((n, 4)), np.zeros((n, 4), dtype=np.int64), np.ones((n, 4), dtype=bool))
    refused = np.array([bool(check(scene_at(rules, poses, k))) for k in range(n)])
    bounds = unproven(rules, poses)
    assert (bounds >= refused).all()
    assert (bounds & ~refused).mean() < 0.05
