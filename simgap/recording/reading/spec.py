"""Reads `measurement.yaml` as a checked `MeasurementSpec`; every finding points at line and column."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from schemas.diagnostics import Diagnostic, finding
from schemas.measurement import MeasurementSpec
from simgap.recording.reading.yaml_text import YamlDocument


def read_spec(document: YamlDocument) -> tuple[MeasurementSpec | None, tuple[Diagnostic, ...]]:
    """The spec, or None with at least one error: unknown keys (with the nearest that exists), missing keys, values."""
    if not isinstance(document.value, dict):
        return None, (
            finding("gap/invalid-value", "the file is not a mapping of keys to values", where=document.place()),
        )
    try:
        return MeasurementSpec.model_validate(_ids_as_written(document)), ()
    except ValidationError as error:
        return None, tuple(_diagnostic(document, e) for e in error.errors(include_url=False, include_context=False))


def _ids_as_written(document: YamlDocument) -> dict[str, Any]:
    """The values with trial ids as text: a file may be called `007.csv`."""
    split = document.value.get("split")
    if not isinstance(split, dict):
        return document.value
    texts = {part: document.texts(("split", part)) for part in split}
    return {**document.value, "split": {p: ids if texts[p] is None else texts[p] for p, ids in split.items()}}


def _diagnostic(document: YamlDocument, error: ErrorDetails) -> Diagnostic:
    path = error["loc"]
    dotted = _dotted(path)
    if error["type"] == "extra_forbidden":
        known = _keys_at(path[:-1])
        near = difflib.get_close_matches(str(path[-1]), known, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"known here: {', '.join(known)}"
        return finding(
            "gap/unknown-key", f"'{dotted}' is no key of a measurement; {hint}", where=document.place(path, of_key=True)
        )
    if error["type"] == "missing":
        return finding("gap/missing-key", f"'{dotted}' is not given", where=document.place(path))
    message = error["msg"].removeprefix("Value error, ")
    return finding(
        "gap/invalid-value",
        f"'{dotted}': {message}" if dotted else message,
        where=document.place(path),
        value=_short(error["input"]),
    )


def _dotted(path: Sequence[str | int]) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")


def _keys_at(path: Sequence[str | int]) -> list[str]:
    """Keys that the node at `path` may have."""
    model: type[BaseModel] = MeasurementSpec
    for step in path:
        if step in model.model_fields:
            model = next(iter(_models_in(model.model_fields[str(step)].annotation)), model)
    return list(model.model_fields)


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models_in(part)]


def _short(value: Any) -> str | None:
    """Scalars only: the text of a list of aliases can be longer than any memory."""
    return str(value)[:60] if isinstance(value, str | int | float | bool) else None
