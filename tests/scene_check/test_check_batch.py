"""The judge of many scenes finds what the judge of one finds, scene by scene."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import Polygon, box

from scene_check import check
from scene_check.batch import BatchPoses, SceneRules, ThingRule, scene_at
from scene_check.check_batch import check_batch, unproven
from schemas.scene.geometry import (
    Domain,
    FixedPose,
    KeepOutVolume,
    PlaceLayer,
    Prism,
    ReachRing,
    ScenePlace,
    SceneRelation,
    Stance,
)

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def prism(width: float, depth: float, low: float = 0.0, high: float = 0.05) -> Prism:
    x, y = width / 2, depth / 2
    return Prism(np.array([(-x, -y), (x, -y), (x, y), (-x, y)]), low, high)


def ell(high: float = 0.05) -> tuple[Prism, ...]:
    """Two pieces whose convex hull covers more than they do."""
    foot = Prism(np.array([(-0.05, -0.05), (0.05, -0.05), (0.05, -0.03), (-0.05, -0.03)]), 0.0, high)
    return foot, Prism(np.array([(-0.05, -0.05), (-0.03, -0.05), (-0.03, 0.05), (-0.05, 0.05)]), 0.0, high)


def form(*prisms: Prism, stance: int = 0, height: float = 0.0) -> tuple[int, Stance]:
    return stance, Stance(UPRIGHT, prisms, height)


HOLED = Polygon(box(-0.5, -0.4, 0.5, 0.4).exterior, [box(0.3, 0.2, 0.4, 0.3).exterior])
TABLE = ScenePlace("top", HOLED, np.array([0.0, 0.0, 0.7]))
TRAY = ScenePlace(
    "top",
    box(-0.15, -0.12, 0.15, 0.12),
    np.array([0.0, 0.0, 0.02]),
    height_m=0.2,
    above=(Prism(np.asarray(box(0.14, -0.12, 0.15, 0.12).exterior.coords)[:-1], 0.0, 0.03),),
)
WIDE = box(-0.07, -0.07, 0.07, 0.07)
BOWL = ScenePlace.volume(
    "inside",
    (PlaceLayer(0.0, 0.03, box(-0.06, -0.06, 0.06, 0.06)), PlaceLayer(0.03, 0.06, WIDE)),
    WIDE,
    np.array([0.0, 0.0, 0.01]),
)


def rules(yaw: float) -> SceneRules:
    on_table = "background", TABLE
    hooks = FixedPose(0.45, -0.35, 0.0, 0.0), FixedPose(0.4, -0.35, 0.02, 0.1)
    things = (
        ThingRule("tray", (form(prism(0.3, 0.24, 0.0, 0.02)),), *on_table, Domain(x_m=(-0.3, 0.0))),
        ThingRule("bowl", (form(prism(0.16, 0.16, 0.0, 0.07)),), *on_table, Domain(yaw_rad=(-0.5, 0.5))),
        ThingRule("ell", (form(*ell()), form(prism(0.08, 0.03), stance=1, height=0.01)), *on_table),
        ThingRule("cup", (form(prism(0.05, 0.05, 0.0, 0.1)), form(prism(0.07, 0.04, 0.0, 0.08))), "tray", TRAY),
        ThingRule("egg", (form(prism(0.04, 0.04)),), "bowl", BOWL),
        ThingRule("peg", (form(prism(0.03, 0.03)),), *on_table, Domain(fixed_poses=hooks)),
    )
    return SceneRules(
        things,
        np.array([0.4, -0.3, 0.1]),
        yaw,
        0.01,
        (
            SceneRelation("before", ("tray", "bowl"), (1.0, 0.0), gap_m=0.02),
            SceneRelation("near", ("tray", "bowl"), (1.0, 0.0), gap_m=0.3),
            SceneRelation("near", ("ell", "bowl"), (1.0, 0.0), gap_m=0.6),
            SceneRelation("far_from", ("bowl", "ell"), (1.0, 0.0), gap_m=0.05),
            SceneRelation("aligned", ("tray", "bowl"), (1.0, 0.0), tolerance=0.25),
            SceneRelation("facing", ("tray", "bowl"), (1.0, 0.0), tolerance=1.2),
            SceneRelation("between", ("cup", "tray", "bowl"), (1.0, 0.0), tolerance=0.3),
            SceneRelation("before", ("cup", "peg"), (1.0, 0.0), frame="tray", gap_m=0.0),
        ),
        (KeepOutVolume("background", TABLE, box(-0.02, -0.4, 0.0, -0.3), 0.1),),
        ReachRing(np.array([0.4, -0.9, 0.0]), 0.1, 1.1, ("bowl", "cup")),
    )


def scenes(yaw: float, n: int, seed: int, astray_m: float) -> BatchPoses:
    """Around a sound scene, everything up to `astray_m` away from where it should be, some of it by micrometres."""
    rng = np.random.default_rng(seed)
    local = np.array([(-0.2, 0.05), (0.2, 0.1), (0.2, -0.2), (0.03, 0.0), (0.0, 0.0), (0.45, -0.35)])
    heights = np.array([0.7, 0.7, 0.7, 0.02, 0.01, 0.7])
    size = astray_m * rng.choice([0.0, 1e-5, 0.1, 1.0], size=(n, 6, 1))
    local = local + size * rng.uniform(-1, 1, (n, 6, 2))
    heights = heights + rng.choice([0.0, 0.0, 0.0, 0.0, 1e-5, 0.02, -0.01], size=(n, 6)) * (astray_m > 0)
    turns = np.concatenate([rng.uniform(-1, 1, (n, 5)), np.zeros((n, 1))], axis=1) * (10.0 * size[..., 0]).clip(0, 1)
    origin, turn = np.zeros((n, 6, 3)), np.zeros((n, 6))
    for i, owner in enumerate((None, None, None, 0, 1, None)):
        at, by = (
            (np.array([[0.4, -0.3, 0.1]]), np.full(n, yaw)) if owner is None else (origin[:, owner], turn[:, owner])
        )
        c, s = np.cos(by), np.sin(by)
        x, y = local[:, i].T
        origin[:, i] = at + np.stack([c * x - s * y, s * x + c * y, heights[:, i]], axis=-1)
        turn[:, i] = by + turns[:, i]
    forms = np.zeros((n, 6), dtype=np.int64)
    forms[:, 3] = rng.integers(0, 2, n)
    forms[:, 2] = rng.integers(0, 8, n) == 0
    origin[:, 2, 2] += 0.01 * forms[:, 2]
    return BatchPoses(origin, turn, forms, rng.random((n, 6)) > 0.01 * (astray_m > 0))


@pytest.mark.parametrize("yaw", [0.0, 0.7])
@pytest.mark.parametrize("astray_m", [0.0, 0.003, 0.05, 0.4])
def test_equal_to_the_judge_of_one_scene(yaw: float, astray_m: float):
    given, stands = rules(yaw), scenes(yaw, 300, 5, astray_m)
    one_by_one = {k: found for k in range(300) if (found := check(scene_at(given, stands, k)))}
    assert dict(check_batch(given, stands)) == one_by_one
    assert 0 < len(one_by_one) <= 300


def test_a_sound_scene_is_proven_by_bounds_alone():
    given, stands = rules(0.7), scenes(0.7, 50, 1, 0.0)
    upright = stands.form[:, 2] == 0
    relaxed = given.relations[:2] + given.relations[3:]  # `near` of a thing of two pieces has no bound
    wide = replace(given, relations=relaxed)
    assert not unproven(wide, stands)[upright].any()
    assert unproven(wide, stands)[~upright].all()


def row(count: int) -> tuple[Prism, ...]:
    """Squares of 2 cm side by side along x from 0 on, one in two missing: no hull is what they cover."""
    square = prism(0.02, 0.02).outline_m
    return tuple(Prism(np.add(square, (0.01 + 0.04 * k, 0.0)), 0.0, 0.05) for k in range(count))


@pytest.mark.parametrize("gap_m", [0.0, 0.03, 0.2])
def test_bounds_prove_most_that_is_near_and_nothing_that_is_not(gap_m: float):
    """A row of twelve pieces, or of three, and an angle of two pieces over it, anywhere and at any heading."""
    wide = box(-2.0, -2.0, 2.0, 2.0)
    things = (
        ThingRule(
            "row",
            (form(*row(12)), form(*row(3), stance=1)),
            "background",
            ScenePlace("floor", wide, np.zeros(3)),
            Domain(orientation_indices=(0, 1)),
        ),
        ThingRule("ell", (form(*ell()),), "row", ScenePlace("top", wide, np.array([0.0, 0.0, 0.05]))),
    )
    relation = SceneRelation("near", ("row", "ell"), (1.0, 0.0), gap_m=gap_m)
    of = SceneRules(things, np.array([0.3, -0.2, 0.0]), 0.4, 0.01, (relation,))
    n, rng = 400, np.random.default_rng(5)
    origin = rng.uniform(-0.3, 0.3, (n, 2, 3)) + of.origin_m
    origin[:, :, 2] = 0.0, 0.05
    yaw, stance = rng.uniform(-np.pi, np.pi, (n, 2)), rng.integers(0, [2, 1], (n, 2))
    poses = BatchPoses(origin, yaw, stance, np.ones((n, 2), dtype=bool))
    near = np.array([not check(scene_at(of, poses, k)) for k in range(n)])
    proven = ~unproven(of, poses)
    assert near[proven].all()
    assert proven[near].mean() > 0.9
    assert 20 < near.sum() < n
