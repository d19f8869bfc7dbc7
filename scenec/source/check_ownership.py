"""Checks ownership: each node has exactly one owner, anchors exist, owners form no cycle, supports stay upright."""

from __future__ import annotations

from collections.abc import Iterator

from scenec.ir.names import Names, anchor_named, kind_of, upright
from schemas.diagnostics import Diagnostic, Label, finding
from schemas.scene.geometry import BACKGROUND
from schemas.scene.placing import DiscretePlacement, Group, Placement, SlotGroup
from source.hint import did_you_mean
from source.tree import Path, Spans, written


def check_ownership(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    """Findings about owners of nodes and of anchors."""
    yield from _one_owner(names, spans)
    yield from _anchors(names, spans)
    for path, placing in _placings(names):
        yield from _place(names, path, placing, spans)
    for i, keep_out in enumerate(names.program.keep_outs):
        yield from _anchor(names, keep_out.surface, "surface", spans, ("keep_outs", i, "surface"))
    for i, rule in enumerate(names.program.keep_clear):
        yield from _kept_clear(names, rule.object, spans, ("keep_clear", i, "object"))
    yield from _circles(names, spans)
    yield from _tipped(names, spans)


def _one_owner(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    layout = names.program.layout
    for name, node in layout.nodes.items():
        path = ("layout", "nodes", name)
        owners: list[Path] = [("layout", "groups", group) for group in names.groups_of.get(name, ())]
        owners = [(*path, "placement"), *owners] if node.placement is not None else owners
        if not owners:
            yield finding("scene/no-owner", f"nothing places the node `{name}`", where=spans.key(path))
        elif len(owners) > 1:
            named = " and ".join(f"`{written(owner)}`" for owner in owners)
            labels = tuple(Label(where=spans.key(owner), text="an owner") for owner in owners)
            yield finding("scene/two-owners", f"`{name}` is placed by {named}", where=spans.key(path), labels=labels)
    for name, group in layout.groups.items():
        for i, member in enumerate(group.members):
            if member in group.members[:i]:
                where = spans.place(("layout", "groups", name, "members", i))
                yield finding("scene/duplicate-id", f"`{member}` is a member of `{name}` twice", where=where)
    placed = {node.object for node in layout.nodes.values()}
    for i, thing in enumerate(names.program.objects):
        if thing.id not in placed:
            where = spans.place(("objects", i, "id"))
            yield finding("scene/unplaced-object", f"no node places the object `{thing.id}`", where=where)


def _anchors(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    program = names.program
    for name, anchor in program.anchors.items():
        path = ("anchors", name, "object")
        placed = names.placed(anchor.object)
        if anchor.object == BACKGROUND and program.background is None and not program.variants.backgrounds:
            headline = f"the anchor `{name}` is on the background, and the program has none"
            yield finding("scene/missing-anchor", headline, where=spans.place(path))
        elif (
            not placed and anchor.object not in names.objects
        ):  # An object that is never placed has a finding of its own.
            known = [BACKGROUND, *names.objects, *program.layout.nodes]
            headline = f"there is no object `{anchor.object}`{did_you_mean(anchor.object, known)}"
            yield finding("scene/unknown-name", headline, where=spans.place(path))
        elif len(placed) > 1:
            headline = f"`{anchor.object}` is placed {len(placed)} times: {', '.join(placed[:4])}"
            yield finding("scene/ambiguous-name", headline, where=spans.place(path))


def _kept_clear(names: Names, name: str, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    program = names.program
    if name == BACKGROUND and program.background is None and not program.variants.backgrounds:
        headline = "a joint of the background is kept clear, and the program has none"
        yield finding("scene/unknown-name", headline, where=spans.place(path))
    elif not names.placed(name) and name not in names.objects:
        known = [BACKGROUND, *names.objects, *program.layout.nodes]
        headline = f"there is no object `{name}`{did_you_mean(name, known)}"
        yield finding("scene/unknown-name", headline, where=spans.place(path))


def _placings(names: Names) -> Iterator[tuple[Path, Placement | Group]]:
    layout = names.program.layout
    for name, node in layout.nodes.items():
        if node.placement is not None:
            yield ("layout", "nodes", name, "placement"), node.placement
    for name, group in layout.groups.items():
        yield ("layout", "groups", name), group


def _place(names: Names, path: Path, placing: Placement | Group, spans: Spans) -> Iterator[Diagnostic]:
    if isinstance(placing, DiscretePlacement | SlotGroup):
        given = [kind for kind in ("surface", "volume") if getattr(placing, kind) is not None]
        if len(given) != 1:
            code = "scene/given-twice" if given else "scene/missing-key"
            headline = f"`{written(path)}` needs one of `surface` and `volume`: the frame of its poses"
            yield finding(code, headline, where=spans.place(path))
            return
    kind = kind_of(placing)
    yield from _anchor(names, anchor_named(placing), kind, spans, (*path, kind))


def _anchor(names: Names, name: str, kind: str, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    anchors = names.program.anchors
    if name in anchors and getattr(anchors[name], kind) is not None:
        return
    if name not in anchors:
        headline = f"no anchor is called `{name}`{did_you_mean(name, anchors)}"
        yield finding("scene/missing-anchor", headline, where=spans.place(path))
        return
    anchor, other = anchors[name], "surface" if kind == "volume" else "volume"
    if getattr(anchor, kind) is None and getattr(anchor, other) is not None:
        labels = (Label(where=spans.key(("anchors", name)), text=f"a {other}"),)
        headline = f"the anchor `{name}` is a {other}, not a {kind}"
        yield finding("scene/missing-anchor", headline, where=spans.place(path), labels=labels)


def _circles(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    owners: dict[str, str] = {}
    for node in names.program.layout.nodes:
        anchor = names.anchor_of(node)
        owner = names.owner(anchor) if anchor is not None else None
        if owner is not None and owner != BACKGROUND:
            owners |= dict.fromkeys(names.copies[node], owner)
    passed: set[str] = set()
    for (
        thing
    ) in owners:  # Each thing has one owner, so that a way upward ends or meets itself, and circles are disjoint.
        at, way = thing, list[str]()
        while at in owners and at not in passed:
            passed.add(at)
            way.append(at)
            at = owners[at]
        if at not in way:
            continue
        circle = way[way.index(at) :]
        start = circle.index(min(circle))
        chain = [*circle[start:], *circle[:start], circle[start]]
        headline = f"{' stands on '.join(f'`{thing}`' for thing in chain)}"
        yield finding("scene/owner-cycle", headline, where=spans.key(("layout", "nodes", chain[0])))


def _tipped(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    """Owners whose orientation may be other than a turn about the vertical."""
    nodes = names.program.layout.nodes
    owners = {names.owner(anchor) for node in nodes if (anchor := names.anchor_of(node)) is not None}
    kept_clear = {thing for rule in names.program.keep_clear for thing in names.placed(rule.object)}
    for name in nodes:
        if not owners.isdisjoint(names.copies[name]) and not upright(names.placing(name)):
            headline = f"`{name}` carries things, but may be turned over"
            yield finding("scene/owner-not-upright", headline, where=spans.key(("layout", "nodes", name)))
        elif not kept_clear.isdisjoint(names.copies[name]) and not upright(names.placing(name)):
            headline = f"a joint of `{name}` is kept clear, but `{name}` may be turned over"
            yield finding("scene/owner-not-upright", headline, where=spans.key(("layout", "nodes", name)))
