"""The solver beyond boxes on a table: owners within owners, receptacles, holes, spots, every kind of relation."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from shapely import Point, box

from benchmarks.scenes.workload import box_body, table
from scenec.check.judge_scene import violations
from scenec.ir.problem import Body, Exhausted, Problem, Solved, Thing
from scenec.solve import ComponentCache, solve
from scenec.solve.check import invalid_things
from scenec.solve.model import model_of
from scenec.solve.search import SearchBudget, search
from schemas.scene.geometry import (
    BACKGROUND,
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


def thing(name: str, body: Body, parent: str = BACKGROUND, place: ScenePlace | None = None, **domain) -> Thing:
    return Thing(name, body, parent, place or table(), Domain(**domain), ("layout", "nodes", name))


def problem(*things: Thing, relations: tuple[SceneRelation, ...] = (), **more) -> Problem:
    return Problem("test", None, np.eye(4), things, relations, 0.01, **more)


def solved(given: Problem, seed: int = 0, **options) -> Solved:
    result = solve(given, seed, **options)
    assert isinstance(result, Solved), result
    assert violations(given, result.placements) == ()
    return result


def cylinder(name: str, radius_m: float, height_m: float = 0.08) -> Body:
    corners = np.array([(radius_m * cos(k * pi / 8), radius_m * sin(k * pi / 8)) for k in range(16)])
    return Body(name, (Stance((1.0, 0.0, 0.0, 0.0), (Prism(corners, 0.0, height_m),), 0.0),))


def tray(width_m: float = 0.4, depth_m: float = 0.3) -> Body:
    """A board with a rim of 6 cm: the surface within is `floor`, and the room within is the volume `inside`."""
    w, d, rim, floor = width_m / 2, depth_m / 2, 0.005, 0.01
    board = box_body("tray", width_m, depth_m, floor).resting_orientations[0].prisms
    sides = ((-w, -d, rim - w, d), (w - rim, -d, w, d), (-w, -d, w, rim - d), (-w, d - rim, w, d))
    outlines = [np.array([(a, b), (c, b), (c, e), (a, e)]) for a, b, c, e in sides]
    inner = box(rim - w, rim - d, w - rim, d - rim)
    origin = np.array([0.0, 0.0, floor])
    surface = ScenePlace("floor", inner, origin, above=tuple(Prism(o, 0.0, 0.06) for o in outlines))
    layers = PlaceLayer(0.0, 0.03, inner.buffer(-0.01, join_style="mitre")), PlaceLayer(0.03, 0.06, inner)
    rims = tuple(Prism(o, 0.0, floor + 0.06) for o in outlines)
    stance = Stance((1.0, 0.0, 0.0, 0.0), (*board, *rims), 0.0)
    return Body("tray", (stance,), (surface,), (ScenePlace.volume("inside", layers, inner, origin),))


def test_mugs_stand_on_a_tray_on_a_table_among_others():
    body = tray()
    mugs = [thing(f"mug{k}", cylinder("mug", 0.04), "tray", body.surfaces[0]) for k in range(4)]
    boxes = [thing(f"box{k}", box_body("box", 0.1, 0.08)) for k in range(12)]
    solved(problem(*mugs, thing("tray", body), *boxes))


def test_contents_lie_within_every_layer_of_a_receptacle_and_below_its_rim():
    body = tray()
    low = [thing(f"low{k}", box_body("low", 0.08, 0.06, 0.04), "tray", body.volumes[0]) for k in range(6)]
    solved(problem(thing("tray", body), *low))
    tall = thing("tall", box_body("tall", 0.08, 0.06, 0.07), "tray", body.volumes[0])
    assert not isinstance(solve(problem(thing("tray", body), tall), budget=200), Solved)


def test_plates_are_stacked_owner_by_owner():
    plates, parent, place = [], BACKGROUND, table()
    for k in range(4):
        body = box_body(f"plate{k}", 0.2 - 0.02 * k, 0.2 - 0.02 * k, 0.015, top=True)
        plates.append(thing(f"plate{k}", body, parent, place))
        parent, place = f"plate{k}", body.surfaces[0]
    solved(problem(*plates[::-1]))


def test_two_boards_of_a_shelf_hold_what_fits_beneath_the_upper_one():
    upper = ScenePlace("upper", box(-0.4, -0.15, 0.4, 0.15), np.array([0.0, 0.0, 0.3]))
    lower = ScenePlace("lower", box(-0.4, -0.15, 0.4, 0.15), np.zeros(3), height_m=0.28)
    things = [thing(f"low{k}", box_body("low", 0.1, 0.1, 0.2), place=lower) for k in range(5)]
    things += [thing(f"high{k}", box_body("high", 0.1, 0.1, 0.5), place=upper) for k in range(5)]
    solved(problem(*things))
    tall = thing("tall", box_body("tall", 0.1, 0.1, 0.29), place=lower)
    assert not isinstance(solve(problem(tall), budget=200), Solved)


def test_a_tall_thing_keeps_clear_of_things_on_a_place_beside_it():
    step = ScenePlace("step", box(0.0, -0.2, 0.4, 0.2), np.array([0.0, 0.0, 0.1]))
    floor = ScenePlace("floor", box(-0.12, -0.2, 0.0, 0.2), np.zeros(3))
    wide = thing("wide", box_body("wide", 0.4, 0.4), place=step)
    near = thing("near", box_body("near", 0.11, 0.11, 0.3), place=floor, yaw_rad=(0.0, 0.0))
    result = solved(problem(wide, near))
    assert result.placements["near"].x_m <= -0.005 + 1e-9


@pytest.mark.parametrize("polygon", [Point(0, 0).buffer(0.4), box(-0.6, -0.4, 0.6, 0.4) - box(-0.2, -0.2, 0.3, 0.1)])
def test_round_tables_and_holes(polygon):
    place = ScenePlace("top", polygon, np.zeros(3))
    solved(problem(*(thing(f"box{k}", box_body("box", 0.09, 0.07), place=place) for k in range(15))))


def test_keep_outs_and_reach_hold_in_a_turned_world():
    angle = 0.7
    X_WB = np.eye(4)
    X_WB[:2, :2] = [[cos(angle), -sin(angle)], [sin(angle), cos(angle)]]
    X_WB[:3, 3] = (1.0, -2.0, 0.5)
    base_W = (X_WB @ (0.0, -0.7, 0.0, 1.0))[:3]
    things = [thing(f"box{k}", box_body("box", 0.08, 0.06)) for k in range(8)]
    keep_out = KeepOutVolume(BACKGROUND, table(), box(-0.3, -0.4, 0.3, -0.2), 0.2, ("keep_outs", 0))
    reach = ReachRing(base_W, 0.3, 0.75, tuple(t.name for t in things), ("reach",))
    given = problem(*things, keep_outs=(keep_out,), reach=reach)
    solved(replace(given, X_WB=X_WB))


def test_a_keep_out_counts_on_a_place_where_nothing_else_stands():
    zone = ScenePlace("zone", table().polygon, np.zeros(3))
    only = thing("a", box_body("a", 0.08, 0.06), x_m=(0.0, 0.1), y_m=(0.0, 0.0))
    rule = KeepOutVolume(BACKGROUND, zone, box(-0.3, -0.3, 0.3, 0.3), 0.2, ("keep_outs", 0))
    assert not isinstance(solve(problem(only, keep_outs=(rule,))), Solved)
    free = solved(problem(only))
    assert [v.kind for v in violations(problem(only, keep_outs=(rule,)), free.placements)] == ["keep_out"]


def test_every_kind_of_relation():
    names = ("a", "b", "c", "d")
    things = [thing(name, box_body(name, 0.08, 0.05)) for name in names]
    solved(
        problem(
            *things,
            thing("e", box_body("e", 0.05, 0.05)),
            relations=(
                SceneRelation("before", ("a", "b"), (1.0, 0.0), gap_m=0.03),
                SceneRelation("near", ("c", "d"), gap_m=0.03),
                SceneRelation("far_from", ("a", "d"), gap_m=0.25),
                SceneRelation("aligned", ("a", "c"), (1.0, 0.0), tolerance=0.0),
                SceneRelation("facing", ("b", "d"), tolerance=0.0),
                SceneRelation("between", ("e", "a", "b"), tolerance=0.02),
            ),
        )
    )


def test_a_relation_across_owners_is_kept_by_the_owners_or_jointly():
    body = tray()
    tray_thing, mug = thing("tray", body), thing("mug", cylinder("mug", 0.03), "tray", body.surfaces[0])
    left = SceneRelation("before", ("mug", "block"), (1.0, 0.0))
    result = solved(problem(tray_thing, mug, thing("block", box_body("block", 0.1, 0.1)), relations=(left,)))
    assert result.placements["tray"].x_m + 0.15 <= result.placements["block"].x_m  # so it holds wherever the mug is
    # Behind the tray there is no room: only the mug itself can be left of the block.
    narrow = thing("block", box_body("block", 0.1, 0.1), x_m=(0.1, 0.1), y_m=(0.3, 0.3), yaw_rad=(0.0, 0.0))
    fixed = thing("tray", body, x_m=(0.0, 0.0), y_m=(0.0, 0.0), yaw_rad=(0.0, 0.0))
    solved(problem(fixed, mug, narrow, relations=(left,)))


def test_relations_in_the_frame_of_a_tray_turn_with_it():
    body = tray()
    mugs = [thing(name, cylinder("mug", 0.03), "tray", body.surfaces[0]) for name in ("a", "b")]
    order = SceneRelation("before", ("a", "b"), (1.0, 0.0), 0.02, frame="tray")
    solved(problem(thing("tray", body, yaw_rad=(2.0, 2.0)), *mugs, relations=(order,)))


def test_components_tied_by_a_direction_share_a_coordinate_and_stay_apart():
    left = [thing(f"left{k}", box_body("box", 0.1, 0.08), x_m=(-0.5, -0.3)) for k in range(4)]
    right = [thing(f"right{k}", box_body("box", 0.1, 0.08), x_m=(0.3, 0.5)) for k in range(4)]
    order = SceneRelation("before", ("left0", "right0"), (0.0, 1.0))
    result = solved(problem(*left, *right, relations=(order,)))
    again = solved(problem(*left, *right[::-1], relations=(order,)))
    assert result == again


def test_each_member_of_a_rack_takes_a_slot_of_its_own():
    slots = tuple(FixedPose(-0.5 + 0.11 * k, 0.0, 0.0, 0.0, name=f"s{k}") for k in range(10))
    things = [thing(f"box{k}", box_body("box", 0.09, 0.09), fixed_poses=slots) for k in range(10)]
    placements = solved(problem(*things)).placements.values()
    assert len({p.x_m for p in placements}) == 10
    one_more = thing("one more", box_body("box", 0.05, 0.05), fixed_poses=slots)
    assert not isinstance(solve(problem(*things, one_more), budget=300), Solved)


def test_exact_search_alone_seats_thirty_boxes_at_any_yaw():
    rng = np.random.default_rng(1)
    given = problem(*(thing(f"box{k}", box_body("box", *rng.uniform(0.04, 0.14, 2))) for k in range(30)))
    model = model_of(given)
    found = search(model, list(model.things), {}, 0, SearchBudget(2000))
    assert found is not None
    assert invalid_things(model, found) == {}
    assert violations(given, {name: placed.placement for name, placed in found.items()}) == ()
    assert sum(abs(sin(4 * placed.placement.yaw_rad)) > 1e-6 for placed in found.values()) > 5


def test_an_edit_moves_what_it_touches_and_no_more():
    things = [thing(f"box{k}", box_body("box", 0.1, 0.08)) for k in range(20)]
    given, cache = problem(*things), ComponentCache()
    before = solved(given, cache=cache).placements
    edited = replace(given, things=(thing("box0", box_body("box", 0.05, 0.05)), *things[1:]))
    after = solved(edited, previous=before, cache=cache).placements
    assert {name for name in before if before[name] != after[name]} <= {"box0"}
    grown = replace(given, things=(thing("box0", box_body("box", 0.3, 0.3)), *things[1:]))
    after = solved(grown, previous=before, cache=cache).placements
    assert 1 <= sum(before[name] != after[name] for name in before) < 15


def test_when_steps_run_out_it_says_how_far_it_got_and_what_was_in_the_way():
    things = [thing(f"box{k}", box_body("box", 0.5, 0.25), yaw_rad=(0.0, 0.0)) for k in range(7)]
    result = solve(problem(*things), budget=300)
    assert isinstance(result, Exhausted)
    assert (result.placed, result.of) == (6, 7)
    assert result.blocking in {t.name for t in things}
    standing = tuple(t for t in things if t.name in result.best_placements)
    assert len(standing) == 6
    assert violations(problem(*standing), result.best_placements) == ()


@pytest.mark.parametrize("seed", range(3))
def test_contents_that_have_no_room_side_by_side_stand_on_each_other(seed: int):
    """Two boards as wide as the bin, and six cans on a floor for four: layers, judged by the checker."""
    origin = np.zeros(3)
    deep = ScenePlace.volume(
        "inside", (PlaceLayer(0.0, 0.2, box(-0.1, -0.1, 0.1, 0.1)),), box(-0.1, -0.1, 0.1, 0.1), origin
    )
    boards = [thing(f"board{k}", box_body("board", 0.15, 0.12, 0.04), place=deep) for k in range(2)]
    found = solved(problem(*boards), seed).placements
    assert sorted(placement.base_m for placement in found.values()) == [0.0, pytest.approx(0.04, abs=2e-6)]
    cans = [thing(f"can{k}", cylinder("can", 0.04), place=deep) for k in range(6)]
    found = solved(problem(*cans), seed).placements
    assert sum(placement.base_m > 0.0 for placement in found.values()) >= 2
    # What stood on a can that is gone does not stay in the air.
    assert solved(problem(*cans[1:]), seed, previous=found)
