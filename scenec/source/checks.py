"""Checks a valid program for ids, names, numbers, ownership, relations and units; all findings in one run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import shapely

from scenec.ir.names import MAX_THINGS, Names
from scenec.ir.single_assets import single_assets
from scenec.source.check_cameras import check_cameras
from scenec.source.check_colours import check_colours
from scenec.source.check_groups import check_groups
from scenec.source.check_ownership import check_ownership
from scenec.source.check_relations import check_relations
from scenec.source.check_units import check_units
from scenec.source.listing import written_assets, written_placings, written_yaws
from scenec.source.paired_materials.library import check_pairs
from schemas.diagnostics import Diagnostic, Label, Severity, finding
from schemas.scene.geometry import BACKGROUND
from schemas.scene.placing import DiscretePlacement, GridGroup, Pose, Ranges, SlotGroup, StackGroup
from schemas.scene.program import AuthoredPolygon, FixedAsset, SceneProgram
from source.hint import did_you_mean
from source.tree import Path, Spans, written


def check_program(program: SceneProgram, spans: Spans) -> tuple[Diagnostic, ...]:
    """All findings about a program that need no asset."""
    names = Names(program)
    if names.count() > MAX_THINGS:
        where = spans.place(("layout", "groups"))
        headline = f"the program places {names.count()} things"
        return (finding("scene/too-many", headline, where=where, value=names.count(), bound=MAX_THINGS, unit="things"),)
    return (
        *_ids(names, spans),
        *_references(names, spans),
        *_numbers(program, spans),
        *_polygons(program, spans),
        *_splits(program, spans),
        *check_colours(program, spans),
        *check_pairs(program, spans),
        *check_units(program, spans),
        *check_groups(program, spans),
        *check_cameras(names, spans),
        *check_ownership(names, spans),
        *check_relations(names, spans),
    )


def unknown(kind: str, name: str, known: Iterable[str], spans: Spans, path: Path) -> Diagnostic:
    """The finding that `name` at `path` is none of the known ones."""
    return finding(
        "scene/unknown-name", f"there is no {kind} `{name}`{did_you_mean(name, known)}", where=spans.place(path)
    )


def _ids(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    program, variants = names.program, names.program.variants
    yield from _twice([(("objects", i, "id"), o.id) for i, o in enumerate(program.objects)], spans, {BACKGROUND: ()})
    yield from _twice([(("keep_outs", i, "id"), k.id) for i, k in enumerate(program.keep_outs)], spans)
    for kind in ("assets", "backgrounds", "slots", "materials", "lighting"):
        ids = [(("variants", kind, i, "id"), v.id) for i, v in enumerate(getattr(variants, kind))]
        yield from _twice(ids, spans)
    for name, group in program.layout.groups.items():
        if isinstance(group, SlotGroup):
            ids = [(("layout", "groups", name, "slots", i, "id"), s.id) for i, s in enumerate(group.slots)]
            yield from _twice(ids, spans)
    nodes = {node: ("layout", "nodes", node) for node in program.layout.nodes}
    groups = [(("layout", "groups", group), group) for group in program.layout.groups]
    copies = [(nodes[n], thing) for n, things in names.copies.items() if len(things) > 1 for thing in things]
    yield from _twice([*groups, *copies], spans, {BACKGROUND: (), **nodes})
    if BACKGROUND in nodes:
        yield from _twice([(nodes[BACKGROUND], BACKGROUND)], spans, {BACKGROUND: ()})


def _twice(ids: list[tuple[Path, str]], spans: Spans, taken: dict[str, Path] | None = None) -> Iterator[Diagnostic]:
    first = dict(taken or {})
    for path, name in ids:
        if name in first:
            claim = "is taken by" if first[name] else "is reserved for"
            other = f"`{written(first[name])}`" if first[name] else "what everything stands on"
            labels = (Label(where=spans.place(first[name]), text="first here"),) if first[name] else ()
            headline = f"the name `{name}` {claim} {other}"
            yield finding("scene/duplicate-id", headline, where=spans.place(path), labels=labels)
        else:
            first[name] = path


def _references(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    """References to objects, members, slots and nodes outside of placements and relations."""
    program, layout = names.program, names.program.layout
    references: list[tuple[str, str, Iterable[str], Path]] = []
    for name, node in layout.nodes.items():
        references.append(("object", node.object, names.objects, ("layout", "nodes", name, "object")))
    for name, group in layout.groups.items():
        path = ("layout", "groups", name)
        references += [("node", m, layout.nodes, (*path, "members", i)) for i, m in enumerate(group.members)]
        if isinstance(group, SlotGroup):
            yield from _assignment(group, group.assign, spans, (*path, "assign"))
    for i, variant in enumerate(program.variants.assets):
        references += [("object", o, names.objects, ("variants", "assets", i, "objects", o)) for o in variant.objects]
    for i, material in enumerate(program.variants.materials):
        path = ("variants", "materials", i, "objects")
        references += [("object", o, [*names.objects, BACKGROUND], (*path, k)) for k, o in enumerate(material.objects)]
    for i, variant in enumerate(program.variants.slots):
        path, group = ("variants", "slots", i), layout.groups.get(variant.group)
        if isinstance(group, SlotGroup):
            yield from _assignment(group, variant.assign, spans, (*path, "assign"))
        else:
            slotted = [name for name, group in layout.groups.items() if isinstance(group, SlotGroup)]
            references.append(("slot group", variant.group, slotted, (*path, "group")))
    if program.reach is not None and program.reach.members != "all":
        known = [*layout.nodes, *layout.groups, *names.things]
        references += [
            ("node or group", m, known, ("reach", "members", i)) for i, m in enumerate(program.reach.members)
        ]
    for kind, name, known, path in references:
        if name not in known:
            yield unknown(kind, name, known, spans, path)


def _assignment(group: SlotGroup, assign: dict[str, str], spans: Spans, path: Path) -> Iterator[Diagnostic]:
    slots, taken = [slot.id for slot in group.slots], dict[str, str]()
    for member, slot in assign.items():
        if member not in group.members:
            yield unknown("member", member, group.members, spans, (*path, member))
        if slot not in slots:
            yield unknown("slot", slot, slots, spans, (*path, member))
        elif slot in taken:
            headline = f"`{taken[slot]}` and `{member}` are both assigned the slot `{slot}`"
            yield finding("scene/slot-assignment", headline, where=spans.place((*path, member)))
        taken.setdefault(slot, member)


def _numbers(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    """Angles given twice, reversed ranges, quaternions that are no rotations."""
    for path, placing in written_placings(program):
        if not isinstance(placing, SlotGroup | DiscretePlacement | StackGroup | GridGroup) and isinstance(
            placing.orientation, tuple
        ):
            quats = [((*path, "orientation", i), quat) for i, quat in enumerate(placing.orientation)]
            yield from _orientations(quats, spans)
    for path, heading in written_yaws(program):
        if not heading.model_fields_set:
            continue
        turned = isinstance(heading, Pose) and heading.quat_wxyz is not None
        if sum((heading.yaw is not None, heading.yaw_deg is not None, turned)) > 1:
            headline = f"`{written(path)}` gives its heading twice"
            yield finding("scene/given-twice", headline, where=spans.place((*path, "yaw_deg")))
        if isinstance(heading, Pose) and heading.quat_wxyz is not None:
            yield from _orientations([((*path, "quat_wxyz"), heading.quat_wxyz)], spans)
        if isinstance(heading, Ranges):
            yield from _reversed(heading, spans, path)
    for i, lighting in enumerate(program.variants.lighting):
        yield from _reversed(lighting, spans, ("variants", "lighting", i))


def _reversed(ranges: object, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    for key in type(ranges).model_fields:  # pyright: ignore[reportAttributeAccessIssue]
        value = getattr(ranges, key)
        if isinstance(value, tuple) and value[0] > value[1]:
            headline = f"`{written((*path, key))}` ends at {value[1]:g} before it begins at {value[0]:g}"
            yield finding(
                "scene/range-reversed", headline, where=spans.place((*path, key)), value=value[1], bound=value[0]
            )


def _orientations(quats: list[tuple[Path, tuple[float, float, float, float]]], spans: Spans) -> Iterator[Diagnostic]:
    for path, quat in quats:
        length = sum(q * q for q in quat) ** 0.5
        if not 0.9 < length < 1.1:  # Quaternions are normalised later; only rounding errors are accepted.
            headline = f"`{written(path)}` is no rotation: its length is not 1"
            yield finding("scene/invalid-value", headline, where=spans.place(path), value=length, bound=1.0)


def _polygons(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    for name, anchor in program.anchors.items():
        for kind, drawn in (("surface", anchor.surface), ("volume", anchor.volume)):
            path = ("anchors", name, kind)
            if not isinstance(drawn, AuthoredPolygon):
                continue
            yield from _polygon(shapely.Polygon(drawn.outline, drawn.holes), spans, path)
            if kind == "volume" and drawn.height is None:
                headline = f"`{written(path)}` needs `height`: how deep the volume is"
                yield finding("scene/missing-key", headline, where=spans.place(path))
    for i, keep_out in enumerate(program.keep_outs):
        path = ("keep_outs", i)
        if (keep_out.outline is None) == (keep_out.ranges is None):
            given = "both an outline and ranges" if keep_out.outline is not None else "neither outline nor ranges"
            code = "scene/given-twice" if keep_out.outline is not None else "scene/missing-key"
            yield finding(code, f"`{written(path)}` has {given}", where=spans.place(path))
        elif keep_out.outline is not None and len(keep_out.outline) < 3:
            headline = f"`{written(path)}.outline` needs three corners"
            yield finding("scene/invalid-value", headline, where=spans.place((*path, "outline")))
        elif keep_out.outline is not None:
            yield from _polygon(shapely.Polygon(keep_out.outline), spans, (*path, "outline"))
        elif keep_out.ranges is not None and keep_out.ranges.model_fields_set & {"yaw", "yaw_deg"}:
            headline = f"`{written(path)}` is a stretch of a surface: a heading has no effect"
            yield finding("scene/option-without-effect", headline, where=spans.place((*path, "ranges")))


def _polygon(polygon: shapely.Polygon, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    if not polygon.is_valid or polygon.area <= 0.0:
        headline = f"`{written(path)}` encloses no area, or crosses itself"
        yield finding("scene/invalid-value", headline, where=spans.place(path), value=shapely.is_valid_reason(polygon))


def _splits(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    candidates = (one for item in written_assets(program) for one in single_assets(item.asset))
    named = sorted({one.id for one in candidates if isinstance(one, FixedAsset)})
    for side, assets in (("train", program.split.train), ("eval", program.split.eval)):
        for i, asset in enumerate(assets):  # A split may serve many programs: only likely misspellings are reported.
            if asset not in named and (hint := did_you_mean(asset, named)):
                headline = f"`{asset}` of the split is no asset of the program{hint}"
                where = spans.place(("split", side, i))
                yield finding("scene/unknown-name", headline, where=where, severity=Severity.WARNING)
    for i, asset in enumerate(program.split.eval):
        if asset in program.split.train:
            first = spans.place(("split", "train", program.split.train.index(asset)))
            yield finding(
                "scene/split-overlap",
                f"`{asset}` is for training and for evaluation",
                where=spans.place(("split", "eval", i)),
                labels=(Label(where=first, text="for training here"),),
            )
