"""Scenes with articulated objects: open drawers hold things, and swept spaces stay free of all others."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely

from cli.scene.output import write_output
from runtime_plan.bodies import physical_body
from runtime_plan.consistency import find_inconsistencies
from scene_check.batch import scene_at
from scene_check.check_batch import check_batch
from scene_check.check_scene import check
from scene_check.from_plan import scene_rules
from scenec.bind.asset_library import AssetLibrary
from scenec.check.judge_plan import extremes
from scenec.check.judge_scene import violations
from scenec.compile import Compiled
from scenec.emit.scene import compiled_scene
from scenec.ir.problem import Placement, Solved
from scenec.plan.document import plan_text
from scenec.session import Session
from scenec.solve import ComponentCache
from schemas.scene.compiled import CompiledScene, PlacedObject
from schemas.scene.program import FixedAsset
from schemas.scene.runtime_plan import RuntimePlan
from tests.support.plan.draws import draws
from tests.support.scene.articulated import (
    DOOR_HINGE_M,
    DOOR_LIMITS_RAD,
    DRAWER_FLOORS_M,
    DRAWER_INSIDE_M,
    articulated_library,
    chest,
    microwave_panels,
)
from tests.support.scene.joint_programs import CLEAR, CUBE, DRAWERS, FLOOR, OVEN, compiled
from usdio.reread.scene import reread_scene


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(articulated_library(tmp_path_factory.mktemp("library")))


def placed(scene: CompiledScene, name: str) -> PlacedObject:
    return next(item for item in scene.objects if item.id == name)


def in_frame_of(owner: PlacedObject, item: PlacedObject) -> list[tuple[np.ndarray, float, float]]:
    """Outlines and heights of an object in the asset frame of an upright owner."""
    w, _, _, z = owner.quat_wxyz
    yaw = 2.0 * math.atan2(z, w)
    back = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    x, y, height = owner.position_m
    return [((p.outline_m - [x, y]) @ back, p.low_m - height, p.high_m - height) for p in item.prisms]


@pytest.mark.parametrize("seed", range(3))
def test_things_lie_in_drawers_where_these_are(library: AssetLibrary, tmp_path: Path, seed: int):
    out = dict(zip(("drawer_1", "drawer_2"), np.random.default_rng(seed).uniform(0.0, 0.25, 2).round(3), strict=True))
    text = DRAWERS % (CUBE, ", ".join(f"{name}: {at}" for name, at in out.items()))
    result = compiled(text, tmp_path, library, seed=seed, diversity=0.05)
    assert result.report.verdict == "compiled", result.report.diagnostics
    unit = placed(result.scenes[0], "unit")
    assert unit.joints == pytest.approx(out)
    depth, width, height = DRAWER_INSIDE_M
    for name, floor, at in zip("ab", DRAWER_FLOORS_M, out.values(), strict=True):
        for outline, low, high in in_frame_of(unit, placed(result.scenes[0], name)):
            assert floor - 1e-6 <= low
            assert high <= floor + height + 1e-6
            assert np.all(np.abs(outline - [at, 0.0]) <= np.array([depth, width]) / 2 + 1e-6)


FIXED = FLOOR + (
    "anchors: {floor: {object: background}}\n"
    "objects: [{id: unit, asset: drawer_unit}, {id: cube, asset: %s}]\n"
    "layout:\n  nodes:\n"
    "    unit: {object: unit, joints: {%s}, placement: {type: discrete, surface: floor, poses: [{x: 0, y: 0}]}}\n"
    "    cube: {object: cube, placement: {type: discrete, surface: floor, poses: [{x: %s, y: 0}]}}\n"
)


@pytest.mark.parametrize(
    ("joints", "x", "fits"), [("", 0.25, True), ("drawer_1: 0.1", 0.25, False), ("drawer_1: 0.1", 0.33, True)]
)
def test_the_footprint_is_that_of_the_state(library: AssetLibrary, tmp_path: Path, joints: str, x: float, fits: bool):
    """The front is at x = 0.181; shut, a cube at 0.25 is clear of it, and a drawer that is 10 cm out reaches there."""
    assert (compiled(FIXED % (CUBE, joints, x), tmp_path, library).report.verdict == "compiled") == fits


def door_hits(scene: CompiledScene) -> list[str]:
    """Objects that the door meets on its way, tried at 300 angles by its own box, not by the swept volume."""
    (panel,) = (panel for panel in microwave_panels() if panel.link == "door")
    corners = shapely.get_coordinates(panel.outline)[:-1] - DOOR_HINGE_M[:2]
    low, high = panel.heights_m
    hit = []
    oven = placed(scene, "oven")
    for item in scene.objects:
        if item.id != "oven":
            for outline, item_low, item_high in in_frame_of(oven, item):
                if min(item_high, high) - max(item_low, low) <= 1e-6:
                    continue
                for q in np.linspace(*DOOR_LIMITS_RAD, 300):
                    turn = np.array([[math.cos(q), math.sin(q)], [-math.sin(q), math.cos(q)]])
                    door = shapely.Polygon(corners @ turn + DOOR_HINGE_M[:2])
                    if door.intersection(shapely.Polygon(outline)).area > 1e-8:
                        hit.append(item.id)
                        break
    return hit


@pytest.mark.parametrize("seed", range(4))
def test_a_joint_kept_clear_meets_nothing_on_its_way(library: AssetLibrary, tmp_path: Path, seed: int):
    result = compiled(OVEN + CLEAR, tmp_path, library, seed=seed)
    assert result.report.verdict == "compiled", result.report.diagnostics
    assert door_hits(result.scenes[0]) == []
    (space,) = result.scenes[0].keep_clear
    assert (space.owner, space.joint) == ("oven", "door")
    assert sum(shapely.Polygon(prism.outline_m).area for prism in space.prisms) > 0.2


@pytest.fixture(scope="module")
def oven(library: AssetLibrary, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    return compiled(OVEN + CLEAR, tmp_path_factory.mktemp("oven"), library, diversity=0.05)


def drawn_scenes(result: Compiled, count: int) -> list[CompiledScene]:
    assert result.plan is not None
    drawn = draws(result.plan, result.plan.combinations[0], np.random.default_rng(0), count)
    return [compiled_scene(result.problems[0], placements, 0) for placements in drawn]


def test_every_draw_of_the_plan_keeps_the_space_clear(oven: Compiled):
    assert oven.plan is not None
    (combination,) = oven.plan.combinations
    (space,) = combination.keep_clear
    assert (space.owner, space.joint, space.links) == ("oven", "door", ("door",))
    pools = [pool for pool in combination.pools if "oven" in pool.things]
    assert len(pools[0].cases) > 10  # the oven is drawn together with what must leave its space free
    assert any(case.family != "point" for case in pools[0].cases)
    for placements in draws(oven.plan, combination, np.random.default_rng(0), 60):
        assert not violations(oven.problems[0], placements)
    assert not any(map(door_hits, drawn_scenes(oven, 12)))


def test_without_the_rule_the_door_does_meet_something(library: AssetLibrary, tmp_path: Path):
    assert any(map(door_hits, drawn_scenes(compiled(OVEN, tmp_path, library, diversity=0.05), 12)))


def test_the_judge_refuses_what_stands_in_the_way(oven: Compiled):
    problem, (result,) = oven.problems[0], oven.results
    assert isinstance(result, Solved)
    at = result.placements["oven"]
    x, y = at.x_m + 0.35 * math.cos(at.yaw_rad), at.y_m + 0.35 * math.sin(at.yaw_rad)
    moved = {**result.placements, "box-1": Placement(x, y, 0.0, 0)}
    found = [wrong for wrong in violations(problem, moved) if wrong.kind == "keep_clear"]
    assert [(wrong.names, wrong.label) for wrong in found] == [(("box-1", "oven"), "door")]
    assert found[0].value > 0.04


def test_the_judge_of_many_scenes_finds_what_that_of_one_does(oven: Compiled):
    plan = oven.plan
    assert plan is not None
    rules = scene_rules(plan, plan.combinations[0])
    poses = extremes(rules, plan.combinations[0], np.arange(40))
    rng = np.random.default_rng(1)
    boxes = [i for i, thing in enumerate(rules.things) if thing.name.startswith("box")]
    origin = poses.origin_m.copy()
    origin[:, boxes, :2] += rng.normal(0.0, 0.15, origin[:, boxes, :2].shape)
    shaken = replace(poses, origin_m=origin)
    found = dict(check_batch(rules, shaken))
    expected = {k: wrong for k in range(40) if (wrong := check(scene_at(rules, shaken, k)))}
    assert found == expected
    assert any(wrong.kind == "keep_clear" for row in expected.values() for wrong in row)
    assert any(all(wrong.kind == "keep_clear" for wrong in row) for row in expected.values())


def test_a_plan_and_its_bodies_are_in_the_state(library: AssetLibrary, tmp_path: Path):
    result = compiled(DRAWERS % (CUBE, "drawer_1: 0.2"), tmp_path, library, diversity=0.05)
    assert result.plan is not None
    plan = RuntimePlan.model_validate_json(plan_text(result.plan))
    assert plan == result.plan
    body = next(body for body in plan.bodies if body.asset_id == "drawer_unit")
    assert dict(body.joints) == {"drawer_1": 0.2, "drawer_2": 0.0}
    rigid = physical_body(body, library.folder).body
    state = library.geometry(FixedAsset(type="fixed", id="drawer_unit"), state=(("drawer_1", 0.2),))
    for one, other in zip(rigid.shapes, state.shapes, strict=True):
        assert np.allclose(one.X_AS, other.X_AS, atol=1e-6)
    places = {place.name: place.link for _, place in plan.combinations[0].places}
    assert places["drawer_1/inside"] == "drawer_1"


def test_a_plan_whose_swept_space_has_no_owner_is_refused(oven: Compiled):
    assert oven.plan is not None
    (combination,) = oven.plan.combinations
    (space,) = combination.keep_clear
    lost = combination.model_copy(update={"keep_clear": (space.model_copy(update={"owner": "stove"}),)})
    assert find_inconsistencies(oven.plan) == ()
    (wrong,) = find_inconsistencies(oven.plan.model_copy(update={"combinations": (lost,)}))
    assert "stove" in wrong.headline


def test_what_lies_in_a_drawer_may_be_in_the_space_that_the_drawer_sweeps(library: AssetLibrary, tmp_path: Path):
    text = DRAWERS % (CUBE, "drawer_1: 0.1")
    result = compiled(text + "keep_clear: [{object: unit, joint: drawer_1}]\n", tmp_path, library)
    assert result.report.verdict == "compiled", result.report.diagnostics


def test_both_drawers_swept_block_what_stands_before_them(library: AssetLibrary, tmp_path: Path):
    """The drawers come out to x = 0.431; the space of the lower one begins 1.5 cm over the floor."""
    rule = "keep_clear: [{object: unit, joint: drawer_1}]\n"
    ahead = compiled(FIXED % (CUBE, "", 0.4) + rule, tmp_path, library)
    assert ahead.report.verdict == "infeasible"
    assert "keep_clear of unit.drawer_1" in ahead.report.proof
    assert [member.path for member in ahead.report.conflict if member.path.startswith("keep_clear")]
    assert any("keep_clear of unit.drawer_1" in label.text for d in ahead.report.diagnostics for label in d.labels)
    beyond = compiled(FIXED % (CUBE, "", 0.47) + rule, tmp_path, library)
    assert beyond.report.verdict == "compiled"
    flat = compiled(FIXED % ("{type: box, size_m: [0.06, 0.06, 0.014]}", "", 0.4) + rule, tmp_path, library)
    assert flat.report.verdict == "compiled"  # the front begins 15 mm over the floor


def test_without_a_proof_the_space_is_named_as_what_could_be_dropped(library: AssetLibrary, tmp_path: Path):
    text = (FIXED % (CUBE, "", 0.3)).replace("type: discrete", "type: surface")
    text = text.replace("poses: [{x: 0, y: 0}]", "ranges: {x: [0, 0.02], y: [0, 0.02], yaw: [0, 0.01]}")
    text = text.replace("poses: [{x: 0.3, y: 0}]", "ranges: {x: [0.29, 0.31], y: [0, 0.02], yaw: [0, 0.01]}")
    result = compiled(text + "keep_clear: [{object: unit, joint: drawer_1}]\n", tmp_path, library, budget=120)
    assert result.report.verdict == "budget_exhausted"
    assert [s.edit for s in result.report.suggestions] == ["drop keep_clear of unit.drawer_1"]


BACKGROUND = (
    "background: {asset: drawer_unit, joints: {drawer_2: 0.22}, yaw_deg: 30, position: [1, 2, 0.1]}\n"
    "anchors: {inside: {object: background, volume: drawer_2/inside}, top: {object: background, surface: auto}}\n"
    "objects: [{id: cube, asset: %s}]\n"
    "layout:\n  nodes:\n"
    "    a: {object: cube, placement: {type: volume, volume: inside}}\n"
    "    b: {object: cube, placement: {type: surface, surface: top}}\n"
    "keep_clear: [{object: background, joint: drawer_2}]\n"
)


def test_the_background_may_be_a_mechanism(library: AssetLibrary, tmp_path: Path):
    result = compiled(BACKGROUND % CUBE, tmp_path, library, diversity=0.05)
    assert result.report.verdict == "compiled", result.report.diagnostics
    scene = result.scenes[0]
    assert scene.background is not None
    assert scene.background.joints == {"drawer_1": 0.0, "drawer_2": 0.22}
    for outline, low, _ in in_frame_of(scene.background, placed(scene, "a")):
        assert np.all(np.abs(outline - [0.22, 0.0]) <= np.array(DRAWER_INSIDE_M[:2]) / 2 + 1e-6)
        assert low == pytest.approx(DRAWER_FLOORS_M[1])


def test_a_session_whose_joints_move_gives_what_a_compile_from_nothing_does(library: AssetLibrary, tmp_path: Path):
    """Drawers are slid in and out; what is in them, and what stands before them, follows."""
    rng, file = np.random.default_rng(3), tmp_path / "p.yaml"
    session = Session(library.folder)
    for _ in range(8):
        low, high = (float(rng.choice([0.0, 0.1, 0.25])) for _ in range(2))
        text = (
            DRAWERS % (CUBE, f"drawer_1: {low}, drawer_2: {high}") + "keep_clear: [{object: unit, joint: drawer_2}]\n"
        )
        file.write_text(text)
        warm = session.compile(file)
        assert warm.report.verdict == "compiled", warm.report.diagnostics
        (problem,), (result,), (scene,) = warm.problems, warm.results, warm.scenes
        assert isinstance(result, Solved)
        assert violations(problem, result.placements) == ()
        assert scene == compiled_scene(problem, result.placements, 0)
        unit = placed(scene, "unit")
        assert unit.joints == {"drawer_1": low, "drawer_2": high}
        for name, at in (("a", low), ("b", high)):
            for outline, _, _ in in_frame_of(unit, placed(scene, name)):
                assert np.all(np.abs(outline[:, 0] - at) <= DRAWER_INSIDE_M[0] / 2 + 1e-6)


COPIES = FLOOR.replace("1.8, 1.4", "2.6, 2.2") + (
    "anchors: {floor: {object: background}}\n"
    "objects: [{id: oven, asset: microwave}, {id: cube, asset: %s}]\n"
    "layout:\n  nodes:\n    stove: {object: oven}\n    cube: {object: cube}\n"
    "  groups: {all: {type: scatter, members: [stove, cube], surface: floor, count: 2}}\n"
    "keep_clear: [{object: %s, joint: door}]\n"
)


def test_a_joint_of_one_copy_can_be_kept_clear(library: AssetLibrary, tmp_path: Path):
    result = compiled(COPIES % (CUBE, "stove-2"), tmp_path, library)
    assert result.report.verdict == "compiled", result.report.diagnostics
    assert [space.owner for space in result.scenes[0].keep_clear] == ["stove-2"]
    (finding,) = compiled(COPIES % (CUBE, "cube-2"), tmp_path, library).report.diagnostics
    assert finding.code == "scene/unknown-joint"
    wrong = (COPIES % (CUBE, "stove-2")).replace("joint: door", "joint: dor")
    assert [d.code for d in compiled(wrong, tmp_path, library).report.diagnostics] == ["scene/unknown-joint"]


def test_the_written_scene_is_in_the_state_that_was_compiled(tmp_path: Path):
    """The coupling takes the latch 2 cm down although every joint is left out; a reader of the scene finds it there."""
    chest(tmp_path / "library", "latched", latch_offset_m=0.02)
    library = AssetLibrary(tmp_path / "library")
    text = FLOOR + (
        "anchors: {floor: {object: background}}\nobjects: [{id: box, asset: latched}]\n"
        "layout: {nodes: {box: {object: box, placement: {type: surface, surface: floor, ranges: {yaw: [0, 0]}}}}}\n"
    )
    result = compiled(text, tmp_path, library, diversity=0.05)
    report = write_output(result, library.folder, tmp_path / "out")
    compiled_lows = sorted(prism.low_m for prism in placed(result.scenes[0], "box").prisms)
    (box,) = [body for body in reread_scene(tmp_path / "out" / str(report.scene)) if body.name == "box"]
    written = [shape.X_AS[2, 3] - shape.size_m[2] / 2 + box.X_WA[2, 3] for shape in box.body.shapes]
    assert sorted(written) == pytest.approx(compiled_lows, abs=1e-5)
    assert result.plan is not None
    body = next(body for body in result.plan.bodies if body.asset_id == "latched")
    simulated = [s.X_AS[2, 3] - s.size_m[2] / 2 for s in physical_body(body, library.folder).body.shapes]
    assert sorted(simulated) == pytest.approx(sorted(prism.low_m for prism in body.stances[0].prisms), abs=1e-5)


BEFORE = (
    "background: {asset: drawer_unit}\n"
    "anchors: {ahead: {object: background, surface: {outline: [[0.2, -0.6], [0.5, -0.6], [0.5, 0.6], [0.2, 0.6]]}}}\n"
    "objects: [{id: cube, asset: %s}]\n"
    "layout:\n  nodes:\n    cube: {object: cube, placement: %s}\n"
    "keep_clear: [{object: background, joint: drawer_1}]\n"
)


def test_what_stands_on_the_owner_leaves_the_space_free_too(library: AssetLibrary, tmp_path: Path):
    anywhere = compiled(BEFORE % (CUBE, "{type: surface, surface: ahead}"), tmp_path, library, diversity=0.05)
    assert anywhere.report.verdict == "compiled"
    for scene in drawn_scenes(anywhere, 30):
        assert scene.background is not None
        for outline, _, _ in in_frame_of(scene.background, placed(scene, "cube")):
            assert abs(outline[:, 1]).min() >= 0.195 - 1e-6 or outline[:, 0].min() >= 0.431 - 1e-6
    x = "{type: discrete, surface: ahead, poses: [{x: 0, y: %s}]}"
    assert compiled(BEFORE % (CUBE, x % 0.0), tmp_path, library).report.verdict == "infeasible"
    assert compiled(BEFORE % (CUBE, x % 0.3), tmp_path, library).report.verdict == "compiled"
    ranges = "{type: surface, surface: ahead, ranges: {x: [0, 0.02], y: [-0.05, 0.05]}}"
    within = compiled(BEFORE % (CUBE, ranges), tmp_path, library)
    assert within.report.verdict == "infeasible"
    assert "keep_clear of background.drawer_1" in within.report.proof


def test_another_joint_is_no_edit_that_the_cache_overlooks(library: AssetLibrary, tmp_path: Path):
    """The upper drawer passes over the cube."""
    cache = ComponentCache()
    text = FIXED % (CUBE, "", 0.4) + "keep_clear: [{object: unit, joint: drawer_2}]\n"
    assert compiled(text, tmp_path, library, cache=cache).report.verdict == "compiled"
    lower = compiled(text.replace("joint: drawer_2", "joint: drawer_1"), tmp_path, library, cache=cache)
    assert lower.report.verdict == "infeasible"


ON_TABLE = FLOOR.replace("1.8, 1.4", "2.0, 1.6") + (
    "anchors: {floor: {object: background}, top: {object: table, surface: auto}}\n"
    "objects: [{id: table, asset: {type: box, size_m: [0.45, 0.6, 0.1]}}, {id: oven, asset: microwave},\n"
    "  {id: post, asset: {type: box, size_m: [0.1, 0.1, 0.3]}}]\n"
    "layout:\n  nodes:\n"
    "    table: {object: table, placement: {type: surface, surface: floor}}\n"
    "    oven: {object: oven, placement: {type: surface, surface: top}}\n"
    "    post: {object: post}\n"
    "  groups: {rest: {type: scatter, members: [post], surface: floor, count: 6}}\n"
)


def test_what_stands_beside_the_table_of_the_owner_leaves_the_space_free(library: AssetLibrary, tmp_path: Path):
    """The door swings out over the edge of the table, where posts of 0.3 m stand on the floor."""
    result = compiled(ON_TABLE + CLEAR, tmp_path, library, diversity=0.05)
    assert result.report.verdict == "compiled"
    assert result.plan is not None
    scenes = drawn_scenes(result, 25)
    assert not any(map(door_hits, [*result.scenes, *scenes]))
    assert len({tuple(placed(scene, "oven").position_m) for scene in scenes}) > 10
    free = compiled(ON_TABLE, tmp_path, library, diversity=0.05)
    assert any(map(door_hits, drawn_scenes(free, 25)))
