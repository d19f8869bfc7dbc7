"""Checks the numbers of groups that place their members relative to one another: stacks."""

from __future__ import annotations

from collections.abc import Iterator

from scenec.source.tree import Spans, written
from schemas.diagnostics import Diagnostic, finding
from schemas.scene.program import SceneProgram, StackGroup


def check_groups(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    """A finding for each range of turns that is reversed, or wider than a whole turn."""
    for name, group in program.layout.groups.items():
        if not isinstance(group, StackGroup):
            continue
        path, (low, high) = ("layout", "groups", name, "turn_deg"), group.turn_deg
        if low > high:
            headline = f"`{written(path)}` ends at {high:g} before it begins at {low:g}"
            yield finding("scene/range-reversed", headline, where=spans.place(path), value=high, bound=low)
        elif high - low > 360.0:
            headline = f"`{written(path)}` is more than a whole turn"
            more = {"value": high - low, "bound": 360.0, "unit": "deg"}
            yield finding("scene/invalid-value", headline, where=spans.place(path), **more)
