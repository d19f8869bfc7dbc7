"""Validates a syntax tree against the pydantic model of the language; every error becomes one finding at its
location."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from functools import partial
from typing import Any, NamedTuple

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from scenec.ir.derivation_cache import DerivationCache
from scenec.source.unknown_keys import unknown_key
from scenec.source.value_messages import message
from schemas.diagnostics import Diagnostic, finding
from schemas.scene.program import LayoutNode, SceneObject, SceneProgram
from source.hint import did_you_mean
from source.tree import Path, Scalar, Spans, Tree, TreeList, TreeMapping, child, plain, written

LONGEST_TEXT = 60


def validate(
    tree: Tree, spans: Spans, derivations: DerivationCache | None = None
) -> tuple[SceneProgram | None, tuple[Diagnostic, ...]]:
    """The program, or None and findings for all invalid keys and values, in the order of the text.

    Objects and nodes whose text is in `derivations` are the same Python objects as before, on whatever line they are.
    """
    if derivations is not None:
        try:
            return SceneProgram.model_validate(_with_known_parts(tree, derivations)), ()
        except ValidationError:
            pass  # validated again below as a whole, for complete findings
    values, as_text = plain(tree), set[Path]()
    while True:
        try:
            return SceneProgram.model_validate(values), ()
        except ValidationError as error:
            places = [_place(tree, detail) for detail in error.errors(include_url=False)]
        numbers = [p.path for p in places if p.error["type"] == "string_type" and _is_number(child(tree, p.path))]
        if not set(numbers) - as_text:
            break
        values = deepcopy(values) if numbers else values  # The tree caches the original.
        for path in numbers:  # An id such as 007 means its text.
            _write(values, path, child(tree, path).text)  # pyright: ignore[reportOptionalMemberAccess,reportAttributeAccessIssue]
        as_text |= set(numbers)
    findings = (_finding(place, tree, spans) for place in _one_each(places))
    return None, tuple(sorted(findings, key=lambda d: (d.where.file or "", d.where.line or 0, d.where.column or 0)))


def _with_known_parts(tree: Tree, derivations: DerivationCache) -> dict[str, Any]:
    """The values of a program, its valid objects and nodes already replaced by models."""
    values = dict(plain(tree))
    objects, nodes = child(tree, ("objects",)), child(tree, ("layout", "nodes"))
    if isinstance(objects, TreeList):
        parts = enumerate(map(plain, objects.items))
        values["objects"] = [
            derivations.get(("object", k), partial(_part, SceneObject, part), part) for k, part in parts
        ]
    if isinstance(nodes, TreeMapping):
        parts = {name: plain(item.value) for name, item in nodes.items.items()}
        known = {
            name: derivations.get(("node", name), partial(_part, LayoutNode, part), part)
            for name, part in parts.items()
        }
        values["layout"] = {**values["layout"], "nodes": known}
    return values


def _part(model: type[SceneObject] | type[LayoutNode], part: Any) -> object:
    try:
        return model.model_validate(part)
    except ValidationError:
        return part


class _Place(NamedTuple):
    """Path of an error, and whether the union alternative that it concerns has the shape of the value."""

    path: Path
    fits: bool
    error: ErrorDetails
    others: tuple[ErrorDetails, ...] = ()

    @property
    def errors(self) -> tuple[ErrorDetails, ...]:
        """Those of all alternatives, that of the one that fits best first."""
        return (self.error, *self.others)


def _place(tree: Tree, error: ErrorDetails) -> _Place:
    """Pydantic's location without the marks of the union alternatives that it tried."""
    node: Tree | None = tree
    path, tag_seen, fits = (), False, True
    for at, step in enumerate(error["loc"]):
        below = child(node, (step,))
        tag = child(node, ("type",))
        if not tag_seen and isinstance(tag, Scalar) and tag.text == step:
            tag_seen = True
        elif below is not None:
            node, path, tag_seen = below, (*path, step), False
        elif at == len(error["loc"]) - 1 and error["type"] == "missing":
            path = (*path, step)
        elif isinstance(step, str):
            fits = fits and _has_shape(step, node)
    return _Place(path, fits, error)


def _has_shape(mark: str, node: Tree | None) -> bool:
    """Whether an alternative, as pydantic marks it, is of the kind of the value."""
    if isinstance(node, TreeList):
        return mark.startswith("tuple[")
    plain_text = mark == "str" or mark.startswith("literal[")
    return plain_text if isinstance(node, Scalar) else not plain_text and not mark.startswith("tuple[")


def _one_each(places: list[_Place]) -> Iterator[_Place]:
    """One place for each path, that of the alternative whose shape fits, with the errors of all alternatives there."""
    fitting = [place for place in places if place.fits]
    chosen: dict[Path, _Place] = {}
    for place in [*fitting, *(p for p in places if not any(f.path[: len(p.path)] == p.path for f in fitting))]:
        chosen.setdefault(place.path, place)
    for path, place in chosen.items():
        others = [other.error for other in places if other.path == path]
        yield place._replace(others=tuple(error for error in others if error is not place.error))


def _finding(place: _Place, tree: Tree, spans: Spans) -> Diagnostic:
    path, kind, context = place.path, place.error["type"], place.error.get("ctx", {})
    above = f"`{written(path[:-1])}`" if path[:-1] else "the program"
    if kind == "extra_forbidden":
        return unknown_key(tree, path, spans.key(path))
    if kind == "missing" and isinstance(path[-1], str):
        return finding("scene/missing-key", f"{above} needs `{path[-1]}`", where=spans.place(path[:-1]))
    if kind == "union_tag_not_found":
        return finding("scene/missing-key", f"`{written(path)}` needs `type`", where=spans.place(path))
    if kind == "union_tag_invalid":
        tags = [tag.strip(" '") for tag in str(context["expected_tags"]).split(",")]
        takes = did_you_mean(str(context["tag"]), tags) or f"; it takes {', '.join(tags)}"
        headline = f"`{written(path)}` has an unknown type{takes}"
        where = spans.place((*path, "type"))
        return finding("scene/invalid-value", headline, where=where, value=context["tag"], bound=", ".join(tags))
    path = path[:-1] if kind == "missing" else path
    node = child(tree, path)
    if len(path) > 1 and path[-2] == "joints" and isinstance(node, TreeList):
        headline = f"`{written(path)}`: a joint has one state in a program, no range"
        return finding("scene/joint-state-range", headline, where=spans.place(path))
    problem = message(place.errors, node.text if isinstance(node, Scalar) else "")
    headline = f"{f'`{written(path)}`' if path else 'the program'} {problem}"
    return finding("scene/invalid-value", headline, where=spans.place(path), value=_shown(node))


def _shown(node: Tree | None) -> str | None:
    return node.text[:LONGEST_TEXT] if isinstance(node, Scalar) else None


def _is_number(node: Tree | None) -> bool:
    return isinstance(node, Scalar) and node.value is not None and not isinstance(node.value, str)


def _write(values: Any, path: Path, text: str) -> None:
    for step in path[:-1]:
        values = values[step]
    values[path[-1]] = text
