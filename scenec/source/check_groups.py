"""Checks groups that place their members relative to one another: turns of stacks, names and members of grids."""

from __future__ import annotations

from collections.abc import Iterator

from schemas.diagnostics import Diagnostic, finding
from schemas.scene.placing import GridGroup, StackGroup
from schemas.scene.program import SceneProgram
from source.tree import Path, Spans, written


def check_groups(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    """Findings about reversed heights, turns that are reversed or more than a whole turn, and cells without members."""
    backgrounds = [(("variants", "backgrounds", i, "background"), v.background) for i, v in
                   enumerate(program.variants.backgrounds)]  # fmt: skip
    for path, background in [(("background",), program.background), *backgrounds]:
        if background is not None and background.height is not None and background.height[0] > background.height[1]:
            at, (low, high) = (*path, "height"), background.height
            headline = f"`{written(at)}` ends at {high:g} before it begins at {low:g}"
            yield finding("scene/range-reversed", headline, where=spans.place(at), value=high, bound=low)
    for name, group in program.layout.groups.items():
        path = ("layout", "groups", name)
        if isinstance(group, StackGroup):
            yield from _turns(group, spans, path)
        elif isinstance(group, GridGroup):
            yield from _grid(group, spans, path)


def _turns(group: StackGroup, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    at, (low, high) = (*path, "turn_deg"), group.turn_deg
    if low > high:
        headline = f"`{written(at)}` ends at {high:g} before it begins at {low:g}"
        yield finding("scene/range-reversed", headline, where=spans.place(at), value=high, bound=low)
    elif high - low > 360.0:
        more = {"value": high - low, "bound": 360.0, "unit": "deg"}
        yield finding(
            "scene/invalid-value", f"`{written(at)}` is more than a whole turn", where=spans.place(at), **more
        )


def _grid(group: GridGroup, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    names = [*group.row_names, *group.column_names]
    for key, lines in (("rows", group.rows), ("columns", group.columns)):
        for k, line in enumerate(() if isinstance(lines, int) else lines):
            if names.count(line) > 1:
                headline = f"`{line}` is the name of more than one row or column of `{path[-1]}`"
                yield finding("scene/duplicate-id", headline, where=spans.place((*path, key, k)))
    cells, members = len(group.row_names) * len(group.column_names), len(group.members)
    if members not in (1, cells) or cells == 0:
        headline = f"`{written(path)}` has {members} members for {cells} cells"
        more = {"value": members, "bound": cells, "unit": "members"}
        yield finding("scene/grid-size", headline, where=spans.place((*path, "members")), **more)
