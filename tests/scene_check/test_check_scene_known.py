"""A scene judged beside one that was valid gives the verdict of a scene judged alone, whatever was changed in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from shapely import box

from scene_check import CheckObject, CheckScene, PosedPlace, check
from scene_check.batch import place_in_world
from schemas.scene.geometry import KeepOutVolume, PlaceLayer, ReachRing, ScenePlace, SceneRelation
from tests.scene_check.test_check_scene import TABLE, TOP, block

KEEP_OUT = TABLE, KeepOutVolume("background", TOP, box(0.45, -0.4, 0.6, 0.4), 0.05)
REACH = ReachRing(np.zeros(3), 0.0, 0.6, ("b0", "b1"))


def crate(x: float, y: float) -> tuple[CheckObject, PosedPlace]:
    """A low block that carries a volume, and that volume."""
    area = box(-0.12, -0.12, 0.12, 0.12)
    inside = ScenePlace.volume("in", (PlaceLayer(0.0, 0.3, area),), area, np.array([0.0, 0.0, 0.05]))
    owner = block("crate", x, y, size=(0.26, 0.26, 0.05))
    return owner, place_in_world("crate", inside, owner.origin_m, 0.0)


def contents(rng: np.random.Generator, inside: PosedPlace) -> list[CheckObject]:
    """Two blocks in a volume, one of them over the other, which may hold it or not."""
    low = block("low", *rng.uniform(-0.08, 0.08, 2), place=inside)
    return [low, block("over", *rng.uniform(-0.06, 0.06, 2), size=(0.05, 0.05, 0.05), base=0.1, place=inside)]


def crowd(rng: np.random.Generator) -> list[CheckObject]:
    owner, inside = crate(*rng.uniform(-0.4, 0.2, 2))
    sizes = rng.uniform(0.04, 0.14, (12, 3))
    loose = [
        block(f"b{k}", *rng.uniform((-0.5, -0.3), (0.5, 0.3)), size=size, yaw=rng.uniform(-3, 3))
        for k, size in enumerate(sizes)
    ]
    return [owner, *contents(rng, inside), *loose]


def scene(objects: list[CheckObject], relations: tuple[SceneRelation, ...]) -> CheckScene:
    there = {item.name for item in objects}
    asked = tuple(relation for relation in relations if there.issuperset(relation.things))
    reach = replace(REACH, members=tuple(name for name in REACH.members if name in there))
    return CheckScene(tuple(objects), 0.01, asked, (KEEP_OUT,), reach)


def relation(rng: np.random.Generator) -> SceneRelation:
    one, two = rng.choice(12, 2, replace=False)
    kind = str(rng.choice(["before", "near", "far_from"]))
    return SceneRelation(kind, (f"b{one}", f"b{two}"), (1.0, 0.0), float(rng.uniform(0.0, 0.3)))


def valid(rng: np.random.Generator) -> CheckScene:
    """What is left of a crowd when whatever takes part in a violation is taken away, owners with their contents."""
    objects, relations = crowd(rng), tuple(relation(rng) for _ in range(4))
    while wrong := check(scene(objects, relations)):
        gone = {wrong[0].names[0]} & {item.name for item in objects} or {objects[-1].name}
        gone |= {"low", "over"} if gone & {"crate", "low"} else set()
        objects = [item for item in objects if item.name not in gone]
    return scene(objects, relations)


def edited(rng: np.random.Generator, known: CheckScene) -> CheckScene:
    """Some objects elsewhere, taken away or new; the owner may move without its contents, or lose what holds them."""
    objects = {item.name: item for item in known.objects}
    fresh = {item.name: item for item in crowd(rng)}
    names = list(fresh)
    for name in rng.choice(names, rng.integers(0, 3), replace=False).tolist():
        objects[name] = fresh[name]
    for name in rng.choice(names, rng.integers(0, 2), replace=False).tolist():
        objects.pop(name, None)
    relations = (*known.relations, *(relation(rng) for _ in range(rng.integers(0, 2))))
    return scene(list(objects.values()), relations)


def test_what_is_judged_beside_a_valid_scene_is_judged_as_if_alone():
    seen = set[str]()
    for seed in range(70):
        rng = np.random.default_rng(seed)
        known = valid(rng)
        assert check(known, known) == ()
        after = edited(rng, known)
        found = check(after, known)
        assert repr(found) == repr(check(after)), seed
        seen |= {violation.kind for violation in found} | ({"none"} if not found else set())
    assert seen > {"none", "clearance", "penetration", "relation", "keep_out", "outside_volume", "unsupported"}


def test_another_clearance_is_judged_everywhere():
    known = CheckScene((block("a", 0.0, 0.0), block("b", 0.115, 0.0)), 0.01)
    assert check(known) == ()
    assert [v.kind for v in check(replace(known, clearance_m=0.02), known)] == ["clearance"]


def test_what_held_contents_is_missed_when_it_is_gone():
    owner, inside = crate(0.0, 0.0)
    low, over = block("low", 0.0, 0.0, place=inside), block("over", 0.0, 0.0, base=0.1, place=inside)
    known = CheckScene((owner, low, over), 0.01)
    assert check(known) == ()
    assert [v.kind for v in check(CheckScene((owner, over), 0.01), known)] == ["unsupported"]
