"""Distractors: rewritten as objects in a scatter group, and checked against the task and its split.

The written program becomes one with an object, a node and a group for each entry, as many copies as there may be at
most. Findings about these are reported where the entry is written.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from scenec.ir.single_assets import single_assets
from scenec.source.listing import written_assets
from schemas.diagnostics import Diagnostic, Label, finding
from schemas.scene.placing import ScatterGroup
from schemas.scene.program import (
    AssetCandidates,
    Distractors,
    FixedAsset,
    LayoutNode,
    PoolAsset,
    SceneObject,
    SceneProgram,
)
from source.tree import Path, Spans, written

TAG = "distractor"


def group_of(entry: Distractors) -> str:
    """Name of the group of an entry; no author can write the node's own name twice."""
    return f"{entry.id}.all"


def with_distractors(program: SceneProgram, spans: Spans) -> tuple[SceneProgram, Spans]:
    """The program with its distractors as objects, and locations that lead to the entries."""
    if not program.distractors:
        return program, spans
    objects, nodes = list(program.objects), dict(program.layout.nodes)
    groups, aliases = dict(program.layout.groups), dict(spans.aliases)
    for i, entry in enumerate(program.distractors):
        here: Path = ("distractors", i)
        aliases[("objects", len(objects))] = here
        candidates = (AssetCandidates(id=entry.id, assets=entry.pool),)
        objects.append(
            SceneObject(id=entry.id, asset=PoolAsset(type="pool", candidates=candidates), semantic_tags=(TAG,))
        )
        if entry.id not in nodes:
            aliases[("layout", "nodes", entry.id)] = here
            nodes[entry.id] = LayoutNode(object=entry.id)
        aliases[("layout", "groups", group_of(entry))] = here
        groups[group_of(entry)] = ScatterGroup(
            type="scatter", members=(entry.id,), surface=entry.surface, count=entry.count[1], ranges=entry.ranges
        )
    layout = program.layout.model_copy(update={"nodes": nodes, "groups": groups})
    rewritten = program.model_copy(update={"objects": tuple(objects), "layout": layout})
    return rewritten, replace(spans, aliases=aliases)


def check_distractors(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    """Findings about entries of the program as written: counts, names, assets that the task or its evaluation uses."""
    task: dict[str, Path] = {}
    for item in written_assets(program):
        for one in single_assets(item.asset):
            if isinstance(one, FixedAsset):
                task.setdefault(one.id, item.path)
    names = {entry.id for entry in program.distractors}.difference(program.layout.nodes)
    for i, entry in enumerate(program.distractors):
        path: Path = ("distractors", i)
        least, most = entry.count
        if least > most:
            headline = f"`{written((*path, 'count'))}` ends at {most} before it begins at {least}"
            where = spans.place((*path, "count"))
            yield finding("scene/range-reversed", headline, where=where, value=most, bound=least)
        if entry.id in program.layout.nodes:
            labels = (Label(where=spans.key(("layout", "nodes", entry.id)), text="first here"),)
            headline = f"the name `{entry.id}` is taken by `layout.nodes.{entry.id}`"
            yield finding("scene/duplicate-id", headline, where=spans.place((*path, "id")), labels=labels)
        for k, asset in enumerate(entry.pool):
            at = (*path, "pool", k)
            if asset in task:
                labels = (Label(where=spans.place(task[asset]), text="of the task"),)
                headline = f"`{asset}` is an asset of the task, and no distractor"
                yield finding("scene/distractor-overlap", headline, where=spans.place(at), labels=labels)
            elif asset in program.split.eval:
                first = spans.place(("split", "eval", program.split.eval.index(asset)))
                labels = (Label(where=first, text="for evaluation here"),)
                headline = f"`{asset}` is for evaluation, and no distractor"
                yield finding("scene/distractor-overlap", headline, where=spans.place(at), labels=labels)
    for path, name in _references(program):
        if name in names or name.rpartition("-")[0] in names:
            headline = f"`{written(path)}` names the distractor `{name}`, which may be absent"
            yield finding("scene/distractor-named", headline, where=spans.place(path))


def _references(program: SceneProgram) -> Iterator[tuple[Path, str]]:
    """Names of things in relations, anchors, groups, spaces kept clear and the reach."""
    for i, relation in enumerate(program.relations):
        for row in relation.words:
            yield from ((("relations", i, row.word, k), name) for k, name in enumerate(relation.members(row)))
    for name, anchor in program.anchors.items():
        yield ("anchors", name, "object"), anchor.object
    for name, group in program.layout.groups.items():
        yield from ((("layout", "groups", name, "members", k), member) for k, member in enumerate(group.members))
    for i, rule in enumerate(program.keep_clear):
        yield ("keep_clear", i, "object"), rule.object
    for i, camera in enumerate(program.cameras):
        if camera.relative_to is not None:
            yield ("cameras", i, "relative_to"), camera.relative_to
        if isinstance(camera.look_at, str):
            yield ("cameras", i, "look_at"), camera.look_at
        yield from ((("cameras", i, "visible", k, "object"), rule.object) for k, rule in enumerate(camera.visible))
    if program.reach is not None and program.reach.members != "all":
        yield from ((("reach", "members", k), name) for k, name in enumerate(program.reach.members))
