"""What a plan document keeps of scene geometry comes back equal, and there is one conversion only."""

from __future__ import annotations

import ast
from dataclasses import replace

import numpy as np
import pytest
from shapely import Polygon, box

from schemas.diagnostics import InvalidInput
from schemas.scene.geometry import (
    Domain,
    FixedPose,
    KeepClear,
    KeepOutVolume,
    PlaceLayer,
    Prism,
    ReachRing,
    ScenePlace,
    SceneRelation,
    Stance,
)
from schemas.scene.plan_geometry import (
    domain_of,
    keep_clear_of,
    keep_out_of,
    place_of,
    polygon_of,
    reach_of,
    relation_of,
    stance_of,
    written_keep_clear,
    written_keep_out,
    written_place,
    written_reach,
    written_relation,
    written_stance,
    written_thing,
)
from schemas.scene.runtime_plan import PlanPolygon
from tests.support.source_tree import PACKAGES, ROOT, parsed, python_files

PRISM = Prism(np.array([(-0.1, -0.1), (0.1, -0.1), (0.0, 0.2)]), 0.0, 0.3)
HOLED = Polygon(box(-0.5, -0.4, 0.5, 0.4).exterior.coords, [box(0.1, 0.1, 0.2, 0.2).exterior.coords])
SHELF = ScenePlace("shelf", HOLED, np.array([0.1, 0.2, 0.7]), 0.4, (PRISM,))
LAYERS = PlaceLayer(0.0, 0.1, box(-0.1, -0.1, 0.1, 0.1)), PlaceLayer(0.1, 0.2, box(-0.2, -0.2, 0.2, 0.2))
BOWL = ScenePlace.volume("inside", LAYERS, LAYERS[1].polygon, np.zeros(3))
DOMAINS = (
    Domain(),
    Domain(x_m=(-0.2, 0.3), yaw_rad=(0.0, 0.0), orientation_indices=(0, 2)),
    Domain(fixed_poses=(FixedPose(0.1, 0.2, 0.3, 0.4, stance=1), FixedPose(0.0, 0.0, 0.0, -1.0))),
)
DOCUMENTS = {"PlanStance", "PlanPolygon", "PlanLayer", "PlanPlace", "PlanSpot", "PlanThing", "PlanRelation",
             "PlanKeepOut", "PlanKeepClear", "PlanReach"}  # fmt: skip


def same(one: object, two: object) -> bool:
    """Whether two values have equal content, fields and corners of arrays and polygons included."""
    if isinstance(one, Polygon | Prism):
        return isinstance(two, Polygon) and bool(one.equals(two)) if isinstance(one, Polygon) else one == two
    if isinstance(one, np.ndarray):
        return np.array_equal(one, np.asarray(two))
    if isinstance(one, tuple):
        return isinstance(two, tuple) and len(one) == len(two) and all(map(same, one, two))
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(two) and all(same(v, getattr(two, k)) for k, v in vars(one).items())
    return one == two


@pytest.mark.parametrize("place", [SHELF, ScenePlace("open", HOLED, np.zeros(3)), BOWL], ids=lambda p: p.name)
def test_places_come_back(place: ScenePlace) -> None:
    assert same(place, place_of(written_place(place)))


def test_stances_relations_and_reach_come_back() -> None:
    stance = Stance((0.5, 0.5, 0.5, 0.5), (PRISM, PRISM), 0.05, "side")
    assert same(stance, stance_of(written_stance(stance)))
    relation = SceneRelation("in_line", ("a", "b"), (0.0, 1.0), 0.1, 0.02, "tray", word="in_line", angle_rad=(0.1, 2.0))
    assert same(relation, relation_of(written_relation(relation)))
    reach = ReachRing(np.array([0.1, -0.5, 0.3]), 0.2, 0.8, ("a", "b"))
    assert same(reach, reach_of(written_reach(reach)))


@pytest.mark.parametrize("domain", DOMAINS)
def test_domains_come_back(domain: Domain) -> None:
    assert same(domain, domain_of(written_thing("a", domain, (0,), "background", 0, ())))


def test_keep_outs_come_back_and_an_open_one_is_a_kilometre_high() -> None:
    keep_out = KeepOutVolume("background", SHELF, box(0.0, 0.0, 0.1, 0.1), 0.2)
    assert same(keep_out, keep_out_of(written_keep_out(keep_out, 3), "background", SHELF))
    open_sky = KeepOutVolume("background", SHELF, box(0.0, 0.0, 0.1, 0.1), np.inf)
    assert written_keep_out(open_sky, 3).height_m == 1000.0


def test_swept_spaces_and_the_links_of_places_come_back() -> None:
    layers = (PlaceLayer(0.0, 0.2, HOLED), PlaceLayer(0.1, 0.3, box(0.0, 0.0, 0.1, 0.1)))
    space = KeepClear("cabinet", "door", ("door", "handle"), layers)
    assert same(space, keep_clear_of(written_keep_clear(space)))
    place = replace(SHELF, link="drawer_1")
    assert same(place, place_of(written_place(place)))
    assert "link" in written_place(place).model_dump()
    assert "link" not in written_place(SHELF).model_dump()  # plans without joints are what they were


def test_no_other_module_makes_these_documents() -> None:
    """A second conversion would be a second place to edit for each new field."""
    makers = {
        path.relative_to(ROOT).as_posix()
        for path in python_files(*PACKAGES)
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in DOCUMENTS
    }
    assert makers == {"schemas/scene/plan_geometry.py"}


def test_an_outline_that_rounding_lets_touch_itself_is_taken_and_a_crossed_one_refused():
    slit = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.0), (0.5, 0.5), (0.5, 1.0), (0.0, 1.0))
    assert polygon_of(PlanPolygon(outline_m=slit, holes_m=())).area == 1.0
    with pytest.raises(InvalidInput):
        polygon_of(PlanPolygon(outline_m=((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)), holes_m=()))
