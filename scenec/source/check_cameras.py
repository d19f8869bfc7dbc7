"""Checks cameras: ids, ranges, and the names of the objects that they look at."""

from __future__ import annotations

from collections.abc import Iterator

from scenec.ir.names import Names
from schemas.diagnostics import Diagnostic, Label, finding
from schemas.scene.cameras import Camera
from source.hint import did_you_mean
from source.tree import Path, Spans, written

WIDEST_DEG = 170.0  # of a lens that projects straight lines to straight lines


def check_cameras(names: Names, spans: Spans) -> Iterator[Diagnostic]:
    """Findings about the cameras of a program, before any asset is looked at."""
    ids: dict[str, Path] = {}
    for i, camera in enumerate(names.program.cameras):
        path: Path = ("cameras", i)
        if camera.id in ids:
            labels = (Label(where=spans.place(ids[camera.id]), text="first here"),)
            headline = f"the name `{camera.id}` is taken by `{written(ids[camera.id])}`"
            yield finding("scene/duplicate-id", headline, where=spans.place((*path, "id")), labels=labels)
        ids.setdefault(camera.id, (*path, "id"))
        yield from _ranges(camera, spans, path)
        for at, name in _named(camera, path):
            yield from _one_thing(names, name, spans, at)


def _named(camera: Camera, path: Path) -> Iterator[tuple[Path, str]]:
    if camera.relative_to is not None:
        yield (*path, "relative_to"), camera.relative_to
    if isinstance(camera.look_at, str):
        yield (*path, "look_at"), camera.look_at
    yield from (((*path, "visible", k, "object"), rule.object) for k, rule in enumerate(camera.visible))


def _ranges(camera: Camera, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    box = camera.position
    ranges: list[tuple[Path, tuple[float, float]]] = [
        ((*path, "position", "x"), box.x), ((*path, "position", "y"), box.y), ((*path, "position", "z"), box.z),
        ((*path, "roll_deg"), camera.roll_deg), ((*path, "fov_deg"), camera.fov_deg),
    ]  # fmt: skip
    for at, (low, high) in ranges:
        if low > high:
            headline = f"`{written(at)}` ends at {high:g} before it begins at {low:g}"
            yield finding("scene/range-reversed", headline, where=spans.place(at), value=high, bound=low)
    low, high = camera.fov_deg
    if low <= 0.0 or high > WIDEST_DEG:
        headline = f"`{written((*path, 'fov_deg'))}` goes beyond what a lens has: more than 0, at most {WIDEST_DEG:g}"
        more = {"value": low if low <= 0.0 else high, "bound": WIDEST_DEG, "unit": "deg"}
        yield finding("scene/invalid-value", headline, where=spans.place((*path, "fov_deg")), **more)


def _one_thing(names: Names, name: str, spans: Spans, path: Path) -> Iterator[Diagnostic]:
    things = names.things_named(name)
    if not things:
        known = [*names.program.layout.nodes, *names.things]
        headline = f"there is no node `{name}`{did_you_mean(name, known)}"
        yield finding("scene/unknown-name", headline, where=spans.place(path))
    elif things != (name,):
        headline = f"`{name}` is placed {len(things)} times: {', '.join(things[:4])}"
        yield finding("scene/ambiguous-name", headline, where=spans.place(path))
