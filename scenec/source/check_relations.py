"""Checks relations as authored: exactly one relation word each, names that exist, options that the word takes."""

from __future__ import annotations

from collections.abc import Iterator

from scenec.ir.names import WORLD, Names
from schemas.diagnostics import Diagnostic, finding
from schemas.scene.geometry import BACKGROUND
from schemas.scene.relations import WORD, Relation, RelationWord
from source.hint import did_you_mean
from source.tree import Path, Spans, written


def check_relations(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    """Findings about each relation, without regard to the others."""
    for i, relation in enumerate(names.program.relations):
        path, words = ("relations", i), relation.words
        if len(words) != 1:
            at_once = " and ".join(row.word for row in words)
            problem = f"says {at_once} at once" if words else "has no relation word"
            yield finding("scene/relation-words", f"`{written(path)}` {problem}", where=spans.place(path))
            continue
        yield from _things(names, words[0], relation.members(words[0]), spans, path)
        yield from _options(relation, words[0], spans, path)
        if relation.frame is not None:
            yield from _frame(names, relation.frame, spans, (*path, "frame"))


def _things(names: Names, row: RelationWord, things: tuple[str, ...], spans: Spans, path: Path) -> Iterator[Diagnostic]:
    known = [*names.program.layout.nodes, *names.program.layout.groups, *names.things, *names.lines]
    seen: set[str] = set()
    for k, name in enumerate(things):
        part = names.part_of(name) if row.parts and k == 0 else None
        stands_for = names.things_named(name if part is None else part[0])
        if not stands_for and name not in names.program.layout.groups:
            headline = f"there is no node or group `{name}`{did_you_mean(name, known)}"
            yield finding("scene/unknown-name", headline, where=spans.place((*path, row.word, k)))
        elif not seen.isdisjoint(stands_for):
            both = sorted(seen.intersection(stands_for))[0]
            headline = f"`{both}` is on both sides of {row.word}"
            yield finding("scene/relation-self", headline, where=spans.place((*path, row.word, k)))
        seen |= set(stands_for)


def _options(relation: Relation, row: RelationWord, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    for key in sorted(relation.model_fields_set - row.keys - set(WORD)):
        allowed = ", ".join(f"`{option}`" for option in sorted(row.keys))
        headline = f"`{key}` has no effect on {row.word}, which takes {allowed}"
        yield finding("scene/option-without-effect", headline, where=spans.key((*path, key)))
    for key, other in row.only_with:
        if key in relation.model_fields_set and not getattr(relation, other):
            headline = f"`{key}` has no effect on {row.word} without `{other}`"
            yield finding("scene/option-without-effect", headline, where=spans.key((*path, key)))
    given = [key for key in row.needs if getattr(relation, key)]
    if row.needs and not given:
        needed = " or ".join(f"`{key}`" for key in row.needs)
        yield finding("scene/missing-key", f"`{written(path)}` needs {needed}", where=spans.place(path))
    elif len(given) > 1:
        headline = f"`{written(path)}` gives {' and '.join(f'`{key}`' for key in given)}, of which one counts"
        yield finding("scene/given-twice", headline, where=spans.key((*path, given[1])))
    for key in sorted(set(row.radians).difference(row.needs)):
        if getattr(relation, key) is not None and getattr(relation, f"{key}_deg") is not None:
            headline = f"`{written(path)}` gives its {key.replace('_', ' ')} twice"
            yield finding("scene/given-twice", headline, where=spans.key((*path, f"{key}_deg")))
    distance = relation.distance
    if isinstance(distance, tuple) and distance[0] > distance[1]:
        headline = f"`{written((*path, 'distance'))}` ends at {distance[1]:g} before it begins at {distance[0]:g}"
        yield finding(
            "scene/range-reversed",
            headline,
            where=spans.place((*path, "distance")),
            value=distance[1],
            bound=distance[0],
        )


def _frame(names: Names, frame: str, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    program = names.program
    placed = (names.owner(frame),) if frame in program.anchors else names.placed(frame)
    if frame != WORLD and not placed:
        known = [WORLD, BACKGROUND, *program.anchors, *program.layout.nodes, *names.objects]
        headline = f"no anchor, node or object is called `{frame}`{did_you_mean(frame, known)}"
        yield finding("scene/unknown-name", headline, where=spans.place(path))
    elif len(placed) > 1:
        headline = f"`{frame}` is placed {len(placed)} times"
        yield finding("scene/ambiguous-name", headline, where=spans.place(path))
