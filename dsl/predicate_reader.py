"""Reads a condition: a mapping with `_func` and the parameters of that predicate, conditions within it included."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast, get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from dsl.mapping_reader import MappingReader, place, shown
from schemas.diagnostics import Diagnostic, Location, finding
from source.hint import did_you_mean
from source.tree import Scalar, Tree, TreeEntry, TreeList, TreeMapping, child, plain
from task.predicates.protocol import Predicate
from task.predicates.table import ALIASES, FUNC, PREDICATES

DEGREES = "_deg"
LARGEST_RAD = 6.3  # a full turn; an angle beyond it is most likely in degrees
_ANGLES = frozenset({"tilt", "tolerance", "turned", "facing"})


def read_predicate(tree: Tree, what: str, findings: list[Diagnostic], at: Location) -> Predicate | None:
    """The predicate, None where something is wrong with it; `what` names it in findings."""
    if not isinstance(tree, TreeMapping):
        findings.append(
            finding("task/invalid-value", f"{what} takes a mapping with `{FUNC}`", where=at, value=shown(tree))
        )
        return None
    reader = MappingReader(tree, what, findings)
    name = reader.text(FUNC, needed=True)
    if name is None:
        return None
    kind = PREDICATES.get(ALIASES.get(name, name))
    if kind is None:
        known = [*PREDICATES, *ALIASES]
        findings.append(
            finding(
                "task/unknown-predicate",
                f"there is no predicate `{name}`{did_you_mean(name, known)}",
                where=place(tree.items[FUNC]),
                value=name,
            )
        )
        return None
    return _checked(tree, kind, f"`{name}`", findings)


def _checked(tree: TreeMapping, kind: type[Predicate], what: str, findings: list[Diagnostic]) -> Predicate | None:
    before = len(findings)
    keys = {key: name for name, field in kind.model_fields.items() for key in written_keys(name, field)}
    angles = [key for key, name in keys.items() if name in _ANGLES]
    reader = MappingReader(tree, what, findings)
    reader.refuse_other_keys([FUNC, *keys, *(key + DEGREES for key in angles)])
    values: dict[str, Any] = {}
    for key, entry in tree.items.items():
        name = keys.get(key)
        if key.endswith(DEGREES) and key.removesuffix(DEGREES) in angles:
            values[key.removesuffix(DEGREES)] = _radians(key, entry, what, findings)
        elif name is not None:
            inside = holds_predicates(kind.model_fields[name].annotation)
            values[key] = _value(name, key, entry, what, findings, holds_conditions=inside)
    if len(findings) > before:
        return None
    try:
        return kind.model_validate(values)
    except ValidationError as error:
        findings += [_finding(tree, keys, detail, what) for detail in error.errors(include_url=False)]
        return None


def written_keys(name: str, field: FieldInfo) -> tuple[str, ...]:
    """Keys by which a program may write a field."""
    alias = field.validation_alias
    if alias is None:
        return (name,)
    return (alias,) if isinstance(alias, str) else tuple(str(choice) for choice in getattr(alias, "choices", ()))


def holds_predicates(annotation: object) -> bool:
    """Whether a field of this type holds a condition or several."""
    if isinstance(annotation, type) and issubclass(annotation, Predicate):
        return True
    return any(map(holds_predicates, get_args(annotation)))


def _value(
    name: str, key: str, entry: TreeEntry, what: str, findings: list[Diagnostic], *, holds_conditions: bool
) -> Any:
    """A parameter: conditions become predicates, other values stay; angles beyond a turn are taken for degrees."""
    value, inner = entry.value, f"`{key}` of {what}"
    if holds_conditions:
        if isinstance(value, TreeList):
            return tuple(read_predicate(item, inner, findings, item.at) for item in value.items)
        return read_predicate(value, inner, findings, entry.at)
    angle = value.value if name in _ANGLES and isinstance(value, Scalar) else None
    if isinstance(angle, int | float) and abs(angle) > LARGEST_RAD:
        headline = f"`{key}` of {what} is {angle:g} rad; did you mean `{key}{DEGREES}: {angle:g}`?"
        findings.append(finding("task/degrees-suspected", headline, where=value.at, value=float(angle), unit="rad"))
    return plain(value)


def _radians(key: str, entry: TreeEntry, what: str, findings: list[Diagnostic]) -> float | None:
    value = entry.value.value if isinstance(entry.value, Scalar) else None
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value) * 3.141592653589793 / 180.0
    MappingReader(TreeMapping({key: entry}, entry.at), what, findings).wrong(key, "takes a number of degrees", entry)
    return None


def _finding(tree: TreeMapping, keys: dict[str, str], error: ErrorDetails, what: str) -> Diagnostic:
    """A finding for what pydantic says about a parameter, in the words of the language."""
    loc: Sequence[int | str] = error["loc"]
    key = str(loc[0]) if loc else ""
    message, kind = _words(error), error["type"]
    if kind == "missing":
        written = next((k for k, name in keys.items() if key in (k, name)), key)
        return finding("task/missing-key", f"{what} needs `{written}`", where=tree.at)
    entry = tree.items.get(key) or tree.items.get(key + DEGREES)
    if entry is None:
        return finding("task/invalid-value", f"{what}: {message}", where=tree.at)
    node = child(entry.value, cast("tuple[int | str, ...]", tuple(loc[1:])))
    where = node.at if isinstance(node, Scalar) else place(entry)
    return finding("task/invalid-value", f"`{key}` of {what} {message}", where=where, value=shown(node or entry.value))


def _words(error: ErrorDetails) -> str:
    """What is wrong with a value."""
    kind, context = error["type"], error.get("ctx", {})
    sentences = {
        "greater_than": "must be above {gt}",
        "greater_than_equal": "must be at least {ge}",
        "less_than_equal": "must be at most {le}",
        "less_than": "must be below {lt}",
        "finite_number": "must be a finite number",
        "float_type": "takes a number",
        "float_parsing": "takes a number",
        "int_type": "takes a whole number",
        "int_parsing": "takes a whole number",
        "int_from_float": "takes a whole number",
        "bool_type": "takes true or false",
        "bool_parsing": "takes true or false",
        "string_type": "takes a text",
        "tuple_type": "takes a list",
        "too_short": "needs at least {min_length} entries",
        "too_long": "takes at most {max_length} entries",
        "literal_error": "must be {expected}",
        "is_instance_of": "takes a condition with `_func`",
    }
    if kind in sentences:
        return sentences[kind].format(**context)
    return error["msg"].removeprefix("Value error, ").removeprefix("Input ")
