"""Tasks in the demo: three episodes over released packages in PyBullet, judged by one graph from their states alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from assetkit.package.record import RECORD
from cli.task.pictures import draw_graph, draw_timeline, verdict
from dsl.task_file import read_task
from geom.pose import pose
from runtime_plan.bodies import physical_body
from runtime_plan.object_facts import object_facts
from schemas.anchors import AnchorPolygon, ContainmentVolume, SupportSurface
from schemas.arrays import FloatArray
from schemas.asset import AssetRecord
from schemas.physics import RigidBody
from schemas.scene.program import BoxAsset
from schemas.scene.runtime_plan import PlanBody
from schemas.task.scene_facts import ObjectFacts, SceneFacts
from sim.bullet.puppet import Carry, Wait, puppet_log
from task.evaluation import evaluate
from task.roles import bind_roles

FOLDER = "tasks"
TASK = """\
instruction: Lift the {thing}, lay it into the {container} and leave it there.
time_limit_s: 12
graph_task_generator:
  nodes:
    - {{id: lift, score: 2, success: {{_func: held_by, object: '@goods'}}}}
    - {{id: place, score: 5, success: {{_func: inside, object: '@goods', container: '@container'}}}}
    - id: leave
      score: 3
      success: {{_func: dwell, for_s: 0.5, of: {{_func: inside, object: '@goods', container: '@container'}}}}
  edges:
    - {{src: lift, dst: place}}
    - {{src: place, dst: leave}}
roles: {{goods: {thing}, container: {container}}}
"""
TABLE_TOP_M, TABLE_M = 0.02, (2.0, 2.0)
LOOSE = 0.7  # share of the opening that the object may take up
LIFT_M = 0.1  # over the rim


@dataclass(frozen=True)
class TaskDemo:
    """Names of the objects, the graph's picture, and for each episode its title, verdict and timeline."""

    thing: str
    container: str
    graph: str
    episodes: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True)
class _Package:
    name: str
    body: RigidBody
    facts: ObjectFacts
    extent_m: FloatArray


def task_demo(library: Path, out: Path) -> TaskDemo | None:
    """Carries an object into a receptacle, beside it, and holds it inside; None where the library has no such pair."""
    packages = [_read(library, file.parent.name) for file in sorted(library.glob(f"*/{RECORD}"))]
    pair = _pair([package for package in packages if package is not None])
    if pair is None:
        return None
    thing, container = pair
    folder = out / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "task.yaml"
    file.write_text(TASK.format(thing=thing.name, container=container.name))
    read, diagnostics = read_task(file)
    if read is None:
        raise RuntimeError(f"the demo's own task has an error: {diagnostics[0].headline}")
    scene = SceneFacts({"table": _table(), thing.name: thing.facts, container.name: container.facts})
    graph, _ = bind_roles(read.graph, scene, read.roles)
    episodes: list[tuple[str, str, str]] = []
    for title, script in _scripts(thing, container).items():
        log = puppet_log(_bodies(thing, container), script)
        result = evaluate(graph, log, scene)
        timeline = folder / f"{title.replace(' ', '_')}.png"
        draw_timeline(graph, result, timeline)
        if not episodes:
            draw_graph(graph, folder / "graph.png", result)
        episodes.append((title, verdict(result), timeline.relative_to(out).as_posix()))
    return TaskDemo(thing.name, container.name, f"{FOLDER}/graph.png", tuple(episodes))


def _read(library: Path, name: str) -> _Package | None:
    record = AssetRecord.model_validate_json((library / name / RECORD).read_bytes())
    if record.physics.links:
        return None
    plan_body = PlanBody(asset_id=name, package=name, scale=1.0, mass_kg=None, primitive=None, stances=())
    body = physical_body(plan_body, library).body
    return _Package(name, body, object_facts(name, body, record), np.array(record.geometry.extent_m.value))


def _pair(packages: Sequence[_Package]) -> tuple[_Package, _Package] | None:
    """The widest receptacle that is smaller than the table, and the largest object that goes into it easily."""
    receptacles = [p for p in packages if p.facts.volumes and p.extent_m[:2].max() < TABLE_M[0] / 3.0]
    receptacles.sort(key=lambda p: p.facts.volumes[0].passes_m)
    for container in reversed(receptacles):
        loose = LOOSE * container.facts.volumes[0].passes_m
        fitting = [p for p in packages if p is not container and p.extent_m.max() < loose]
        if fitting:
            return max(fitting, key=lambda p: float(p.extent_m.max())), container
    return None


def _bodies(thing: _Package, container: _Package) -> list[tuple[str, RigidBody, FloatArray, bool]]:
    slab = BoxAsset(type="box", size_m=(*TABLE_M, TABLE_TOP_M))
    table = PlanBody(asset_id="table", package=None, scale=1.0, mass_kg=None, primitive=slab, stances=())
    on_table = np.array([0.0, 0.0, TABLE_TOP_M])
    return [
        ("table", physical_body(table, None).body, np.eye(4), False),
        (container.name, container.body, pose(None, on_table), True),
        (thing.name, thing.body, _beside(thing, container), True),
    ]


def _beside(thing: _Package, container: _Package) -> FloatArray:
    """(4, 4) where the object stands at first: left of the container, on the table."""
    x = -(container.extent_m[0] / 2.0 + thing.extent_m[:2].max() + 0.05)
    return pose(None, np.array([x, 0.0, TABLE_TOP_M]))


def _scripts(thing: _Package, container: _Package) -> dict[str, tuple[Carry | Wait, ...]]:
    volume = container.facts.volumes[0]
    assert isinstance(volume, ContainmentVolume)
    start = _beside(thing, container)
    floor = np.array([*volume.position_m[:2], TABLE_TOP_M + volume.position_m[2]])
    high = TABLE_TOP_M + container.extent_m[2] + LIFT_M
    other_side = np.array([-start[0, 3], 0.0, TABLE_TOP_M])

    def way(end: FloatArray) -> FloatArray:
        over = [np.array([start[0, 3], 0.0, high]), np.array([end[0], end[1], high])]
        return np.stack([start, *(pose(None, at) for at in over), pose(None, end)])

    inside = floor + np.array([0.0, 0.0, 0.01])
    return {
        "laid inside": (Wait(0.5), Carry(thing.name, way(inside), 3.0), Wait(2.0)),
        "laid beside": (Wait(0.5), Carry(thing.name, way(other_side + np.array([0.0, 0.0, 0.01])), 3.0), Wait(9.0)),
        "held inside": (Wait(0.5), Carry(thing.name, way(inside), 3.0, hold=True), Wait(9.0)),
    }


def _table() -> ObjectFacts:
    x, y = TABLE_M[0] / 2.0, TABLE_M[1] / 2.0
    top = SupportSurface(
        anchor_id="top",
        position_m=(0.0, 0.0, TABLE_TOP_M),
        polygon=AnchorPolygon(outline_m=((-x, -y), (x, -y), (x, y), (-x, y))),
        normal=(0.0, 0.0, 1.0),
        area_m2=4.0 * x * y,
        clearance_m=None,
        load_directions=((0.0, 0.0, 1.0),),
    )
    return ObjectFacts("table", np.array([[-x, -y, 0.0], [x, y, TABLE_TOP_M]]), "table", surfaces=(top,))
