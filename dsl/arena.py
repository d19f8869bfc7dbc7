"""Environments as Isaac Lab Arena's graphs, and back: one stage is atomic, a chain sequential, an antichain parallel.

Arena's tasks have no partial order, so that any other graph is refused, or written as parallel stages with the list of
what is lost. Each subtask carries the stage as ordered under `params.mana_stage`, which Arena passes over: reading the
file again gives the same order.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from schemas.task.orders import AssemblyOrder, Orders, RobotOrder, SceneOrder, TaskNodeOrder, TaskOrder
from task.predicates.table import ALIASES, FUNC
from task.roles import MARK

STAGE, SIMREADY = "mana_stage", "simready_usd_object"


class NotExportable(Exception):
    """An environment that Arena's graphs cannot hold; the text has every reason, a line each."""


@dataclass(frozen=True)
class ArenaGraph:
    """The document, and what of the environment it does not hold."""

    document: dict[str, Any]
    lost: tuple[str, ...]


def export_environment(orders: Orders, assembly: AssemblyOrder, assets: str, *, lossy: bool = False) -> ArenaGraph:
    """The graph of an assembly; packages lie below the folder `assets`. Raises NotExportable, unless `lossy`."""
    scene = next(each for each in orders.scenes if each.name == assembly.scene)
    robot = next(each for each in orders.robots if each.name == assembly.robot)
    task = next(each for each in orders.tasks if each.name == assembly.task)
    lost: list[str] = []
    background, objects, sets, relations = _scene(scene, assets, lost)
    composition, subtasks = _task(task, assembly.bindings, lost)
    if lost and not lossy:
        raise NotExportable("\n".join(lost))
    if not subtasks:
        raise NotExportable("no stage has a counterpart in Arena")
    document = {
        "env_name": assembly.name,
        "embodiment": _embodiment(robot),
        "background": background,
        "objects": objects,
        "object_sets": sets,
        "object_references": [],
        "relations": relations,
        "task": {"composition": composition, "description": task.instruction or task.name, "subtasks": subtasks},
    }
    return ArenaGraph({key: value for key, value in document.items() if value is not None}, tuple(lost))


def import_task(document: Mapping[str, Any], name: str, like: TaskOrder) -> TaskOrder:
    """The task order of a document; fields of the whole task that Arena does not hold are those of `like`.

    Raises ValueError for a subtask that was not written by Mana.
    """
    subtasks = document["task"]["subtasks"]
    stages: list[TaskNodeOrder] = []
    for subtask in subtasks:
        stage = subtask.get("params", {}).get(STAGE)
        if stage is None:
            raise ValueError(f"the subtask {subtask.get('kind')} does not hold the stage that it was made from")
        stages.append(TaskNodeOrder.model_validate(stage))
    if document["task"]["composition"] == "sequential":
        chain = [(), *((stage.id,) for stage in stages[:-1])]
        stages = [s.model_copy(update={"waits_for": waits}) for s, waits in zip(stages, chain, strict=True)]
    return like.model_copy(update={"name": name, "nodes": tuple(stages)})


def composition_of(nodes: Sequence[TaskNodeOrder]) -> str | None:
    """`atomic`, `sequential` or `parallel`; None for any other partial order."""
    if len(nodes) == 1:
        return "atomic"
    if not any(node.waits_for for node in nodes):
        return "parallel"
    is_chain = not nodes[0].waits_for and all(b.waits_for == (a.id,) for a, b in pairwise(nodes))
    return "sequential" if is_chain else None


def _task(task: TaskOrder, bindings: Mapping[str, Sequence[str]], lost: list[str]) -> tuple[str, list[dict[str, Any]]]:
    subtasks: list[dict[str, Any]] = []
    held: list[TaskNodeOrder] = []
    for node in task.nodes:
        subtask = _subtask(node, bindings)
        if subtask is None:
            lost.append(f"the stage `{node.id}` ({node.success[FUNC]}) has no counterpart in Arena")
        else:
            subtasks.append(subtask)
            held.append(node)
    if task.failure is not None:
        lost.append("the failure condition of the task")
    lost += [f"the failure condition of the stage `{node.id}`" for node in held if node.failure is not None]
    composition = composition_of(held) if held else "atomic"
    if composition is None:
        lost += [f"the edge {before} -> {node.id}" for node in held for before in node.waits_for]
        composition = "parallel"
    return composition, subtasks


def _subtask(node: TaskNodeOrder, bindings: Mapping[str, Sequence[str]]) -> dict[str, Any] | None:
    """Kind and parameters of a stage by the first of its conditions that Arena knows."""
    for condition in _conditions(node.success):
        func = ALIASES.get(condition[FUNC], condition[FUNC])

        def named(key: str, condition: Mapping[str, Any] = condition) -> str:
            name = str(condition[key])
            return bindings[name][0] if name.startswith(MARK) and bindings.get(name) else name

        params: dict[str, Any] | None = None
        kind = ""
        if func in ("inside", "on", "near"):
            goal = {"inside": "container", "on": "support", "near": "destination"}[func]
            kind = "PickAndPlaceTask"
            params = {"pick_up_object": named("object"), "destination_location": named(goal)}
        elif func in ("held_by", "raised"):
            kind, params = "LiftObjectTask", {"lift_object": named("object")}
        elif func == "joint_at":
            kind = "OpenDoorTask" if "at_least" in condition else "CloseDoorTask"
            thing, _, joint = str(condition["joint"]).partition("/")
            params = {"openable_object": thing, "joint": joint}
        elif func == "pressed" and condition.get("times", 1) == 1:
            thing, _, joint = str(condition["joint"]).partition("/")
            kind, params = "PressButtonTask", {"pressable_object": thing, "joint": joint}
        if params is not None:
            stage = node.model_dump(mode="json", exclude_defaults=True)
            return {"kind": kind, "params": {**params, STAGE: stage}}
    return None


def _conditions(condition: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """A condition and those that it demands as well; not those of `negation` or of alternatives."""
    yield condition
    if condition[FUNC] in ("dwell", "all_of"):
        inner = condition["of"]
        for each in inner if isinstance(inner, list) else [inner]:
            yield from _conditions(each)


def _embodiment(robot: RobotOrder) -> dict[str, Any]:
    registry = str(robot.fragment.get("kinematics", robot.name))
    params = {"gripper_variant": robot.gripper_variant} if robot.gripper_variant else {}
    return {"id": robot.name, "registry_name": registry, "params": params}


def _scene(
    scene: SceneOrder, assets: str, lost: list[str]
) -> tuple[dict[str, Any] | None, list[dict[str, Any]], list[dict[str, Any]], list[dict[str, Any]]]:
    program = scene.program
    things = {thing["id"]: thing for thing in program.get("objects", [])}
    anchors: Mapping[str, Any] = program.get("anchors", {})
    objects: list[dict[str, Any]] = []
    sets: list[dict[str, Any]] = []
    relations: list[dict[str, Any]] = []
    for name, node in program.get("layout", {}).get("nodes", {}).items():
        members = _members(things.get(node.get("object", name), {}).get("asset"))
        if members is None:
            lost.append(f"the object `{name}`: an inline shape is no package")
        elif len(members) == 1:
            objects.append({"id": name, **_simready(members[0], assets)})
        else:
            sets.append({"id": name, "members": [{"id": each, **_simready(each, assets)} for each in members]})
        placement = node.get("placement", {})
        anchor = anchors.get(placement.get("surface") or placement.get("volume") or "", {})
        if members is not None and "object" in anchor:
            kind = "in" if "volume" in placement else "on"
            relations.append({"kind": kind, "subject": name, "reference": anchor["object"], "params": {}})
    background = program.get("background", {}).get("asset")
    members = _members(background)
    if background is None or members is None or len(members) != 1:
        lost.append("the background: an inline shape or a pool is no package")
        return None, objects, sets, relations
    return {"id": "background", **_simready(members[0], assets)}, objects, sets, relations


def _members(asset: object) -> list[str] | None:
    """Ids of the packages that an asset may be; None for an inline shape."""
    if isinstance(asset, str):
        return [asset]
    if isinstance(asset, dict):
        if asset.get("type") == "fixed":
            return [str(asset["id"])]
        if asset.get("type") == "pool":
            return [str(one) for group in asset["candidates"] for one in group["assets"]]
    return None


def _simready(asset_id: str, assets: str) -> dict[str, Any]:
    return {"registry_name": SIMREADY, "params": {"usd_path": f"{assets}/{asset_id}/usd/{asset_id}.usda"}}
