"""What the conditions of a task need of a scene and the scene cannot give: volumes, surfaces, joints, attributes.

Every condition is evaluated on one made-up frame in which everything stands at the origin: what it reads and does not
find is missing in any episode of that scene. Assets are known by their records; a pool has what all its assets have.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import ValidationError

from schemas.anchors import AnchorPolygon, ContainmentVolume, SupportSurface
from schemas.asset import RECORD, AssetRecord
from schemas.scene.program import BoxAsset, CylinderAsset, SceneProgram
from schemas.task.scene_facts import ObjectFacts, SceneFacts
from schemas.task.state_log import StateLog
from task.frames import Frames, StateMissing
from task.graph import TaskGraph
from task.predicates.combine.counted import MEMBER
from task.predicates.protocol import Predicate

_SIDES = 16  # of the polygon that stands for a round top


class Candidate(NamedTuple):
    """What is known of an asset: its anchors, the names of its joints, its category; `known` whether anything is."""

    volumes: tuple[ContainmentVolume, ...]
    surfaces: tuple[SupportSurface, ...]
    joints: frozenset[str]
    attributes: Mapping[str, str]
    known: bool


UNKNOWN = Candidate((), (), frozenset(), {}, known=False)


class Missing(NamedTuple):
    """A node (empty for the task) and one line that names what its condition does not find."""

    node: str
    words: str


def missing_needs(graph: TaskGraph, program: SceneProgram, assets: Path | None) -> tuple[Missing, ...]:
    """What conditions of a graph with bound roles do not find in a scene. Objects of unknown assets lack nothing."""
    objects = scene_objects(program, assets)
    facts = SceneFacts({name: _facts(name, each) for name, each in objects.items()})
    joints = tuple(f"{name}/{joint}" for name, each in objects.items() for joint in sorted(each.joints))
    frames = Frames(_one_frame(tuple(objects), joints), facts, 0, 1)
    unknown = {name for name, each in objects.items() if not each.known}
    lacking = (
        Missing(node, str(missing))
        for node, condition in _conditions(graph)
        for part in condition.parts()
        if _is_of_the_scene(part) and (missing := _first_missing(part, frames)) and missing.about not in unknown
    )
    return tuple(dict.fromkeys(lacking))


def _is_of_the_scene(part: Predicate) -> bool:
    """Whether a condition reads objects of the scene alone: robots are not known, and `$member` is none by itself."""
    return MEMBER not in set(part.objects()) and "home" not in part.channels()


def scene_objects(program: SceneProgram, assets: Path | None) -> dict[str, Candidate]:
    """What is known of each placed object and of the background."""
    things = {thing.id: thing.asset for thing in program.objects}
    placed = {name: things.get(node.object or name) for name, node in program.layout.nodes.items()}
    if program.background is not None:
        placed["background"] = program.background.asset
    return {name: _candidate(asset, assets) for name, asset in placed.items()}


def _candidate(asset: Any, assets: Path | None) -> Candidate:
    if isinstance(asset, BoxAsset | CylinderAsset):
        return Candidate((), (_top(asset),), frozenset(), {}, known=True)
    ids = _asset_ids(asset)
    records = [_record(assets, each) for each in ids] if assets is not None else []
    known = [record for record in records if record is not None]
    if not known or len(known) < len(ids):
        return UNKNOWN
    every = [_of_record(record) for record in known]
    return Candidate(
        _common(each.volumes for each in every),
        _common(each.surfaces for each in every),
        frozenset.intersection(*(each.joints for each in every)),
        dict(set.intersection(*(set(each.attributes.items()) for each in every))),
        known=True,
    )


def _asset_ids(asset: Any) -> list[str]:
    if isinstance(asset, str):
        return [asset]
    if hasattr(asset, "candidates"):
        return [each for group in asset.candidates for each in group.assets]
    return [asset.id] if hasattr(asset, "id") else []


def _record(assets: Path | None, asset_id: str) -> AssetRecord | None:
    if assets is None or Path(asset_id).name != asset_id:
        return None
    try:
        return AssetRecord.model_validate_json((assets / asset_id / RECORD).read_bytes())
    except (OSError, ValidationError):
        return None


def _of_record(record: AssetRecord) -> Candidate:
    anchors = [anchor.value for anchor in record.anchors]
    return Candidate(
        tuple(each for each in anchors if isinstance(each, ContainmentVolume)),
        tuple(each for each in anchors if isinstance(each, SupportSurface)),
        frozenset(str(joint.value["name"]) for joint in record.physics.joints if "name" in joint.value),
        {"category": record.semantics.category.value},
        known=True,
    )


def _common(anchors: Iterable[Sequence[Any]]) -> tuple[Any, ...]:
    """Anchors of the first asset whose names all the others have too."""
    every = list(anchors)
    names = set.intersection(*({each.anchor_id for each in one} for one in every))
    return tuple(each for each in every[0] if each.anchor_id in names)


def _top(asset: BoxAsset | CylinderAsset) -> SupportSurface:
    if isinstance(asset, BoxAsset):
        x, y, height = asset.size_m[0] / 2.0, asset.size_m[1] / 2.0, asset.size_m[2]
        outline = ((-x, -y), (x, -y), (x, y), (-x, y))
    else:
        turn = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
        outline = tuple((float(asset.radius_m * np.cos(a)), float(asset.radius_m * np.sin(a))) for a in turn)
        height = asset.height_m
    return SupportSurface(
        anchor_id="top",
        position_m=(0.0, 0.0, height),
        polygon=AnchorPolygon(outline_m=outline),
        normal=(0.0, 0.0, 1.0),
        area_m2=1.0,
        clearance_m=None,
        load_directions=((0.0, 0.0, 1.0),),
    )


def _facts(name: str, known: Candidate) -> ObjectFacts:
    corners = np.array(list(product((-0.01, 0.01), repeat=3)))
    facts = ObjectFacts(name, corners, name, volumes=known.volumes, surfaces=known.surfaces)
    return replace(facts, attributes=known.attributes)


def _one_frame(bodies: tuple[str, ...], joints: tuple[str, ...]) -> StateLog:
    count = len(bodies)
    return StateLog(
        np.zeros(1),
        bodies,
        np.zeros((1, count, 3)),
        np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (1, count, 1)),
        joints,
        np.zeros((1, len(joints))),
        (),
        np.zeros((1, 0), dtype=bool),
    )


def _conditions(graph: TaskGraph) -> Iterable[tuple[str, Predicate]]:
    for node in graph.nodes:
        for condition in (node.success, node.failure):
            if condition is not None:
                yield node.node_id, condition
    if graph.failure is not None:
        yield "", graph.failure


def _first_missing(part: Predicate, frames: Frames) -> StateMissing | None:
    try:
        part.values(frames, part.start())
    except StateMissing as missing:
        return missing
    return None
