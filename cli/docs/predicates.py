"""The page `docs/reference/predicates.md` from the table of predicates and the fields of each."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from dsl.predicate_reader import holds_predicates, written_keys
from task.predicates.protocol import ROLE, Predicate
from task.predicates.table import ALIASES, PREDICATES

_INTRODUCTION = """# Predicates

{count} conditions that a [task file](task-file.md) may state as `success` or `failure`: `_func` names one, the other
keys are its parameters. They read a state log and the facts of the scene, nothing else, so that an episode judged while
it runs and one judged from its log get the same answer. Lengths are metres, times seconds, angles radians; a parameter
in radians may be written with `_deg` at its end. Joints are `<object>/<joint>`.

Where a gripper holds an object it is not placed: `inside`, `on`, `near`, `beside`, `aligned`, `stacked`, `inserted`,
`hung` and `covered` wait for the release unless `while_held: true` stands there. Those that remember (`dwell`,
`pressed`, `joint_turned`, `sequence`) begin when their node becomes active. To add one see
[adding a predicate](../contributing/predicate.md).

`$member` stands for each member in turn within `where` of `counted` and `all_and_only`. {aliases}
"""


def page() -> str:
    """The page as text."""
    aliases = ", ".join(f"`{alias}` is another name of `{name}`" for alias, name in ALIASES.items())
    sections = [_section(name, kind) for name, kind in PREDICATES.items()]
    return _INTRODUCTION.format(count=len(PREDICATES), aliases=f"{aliases[:1].upper()}{aliases[1:]}.") + "".join(
        sections
    )


def _section(name: str, kind: type[Predicate]) -> str:
    summary = (inspect.getdoc(inspect.getmodule(kind)) or "").partition("`: ")[2]
    rows = "".join(_row(field_name, field) for field_name, field in kind.model_fields.items())
    reads = ", ".join(sorted(kind.needs)) or "what its conditions read"
    meaning = inspect.getdoc(kind) or ""
    return (
        f"\n## `{name}`\n\n{_own_summary(name, summary)}{meaning}\n\nReads: {reads}.\n\n"
        f"| parameter | default | meaning |\n|---|---|---|\n{rows}"
    )


def _own_summary(name: str, summary: str) -> str:
    """The first line of the file, where the file has one predicate."""
    return "" if name in {"all_of", "any_of", "negation"} else f"{summary[:1].upper()}{summary[1:]}\n\n"


def _row(name: str, field: FieldInfo) -> str:
    keys = " or ".join(f"`{key}`" for key in written_keys(name, field))
    default = "needed" if field.default is PydanticUndefined else _value(field.default)
    return f"| {keys} | {default} | {field.description or _kind(field)} |\n"


def _kind(field: FieldInfo) -> str:
    if ROLE in field.metadata:
        return "objects by name or tag" if "tuple" in str(field.annotation) else "an object by its name or tag"
    if holds_predicates(field.annotation):
        return "a condition" if isinstance(field.annotation, type) else "conditions"
    choices = getattr(field.annotation, "__args__", ())
    if choices and all(isinstance(choice, str) for choice in choices):
        return " or ".join(f"`{choice}`" for choice in choices)
    names: Mapping[Any, str] = {bool: "true or false", int: "a whole number", float: "a number", str: "a name"}
    return next((words for kind, words in names.items() if kind is field.annotation or kind in choices), "a number")


def _value(value: object) -> str:
    if value is None or value == ():
        return ""
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"
