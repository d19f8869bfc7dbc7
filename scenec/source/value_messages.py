"""What is wrong with a value, in the words of the language: lists, mappings, numbers and text, never Python's types."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic_core import ErrorDetails

from source.hint import did_you_mean

_KINDS = {
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
    "string_type": "text",
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "finite_number": "a finite number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
}
_BOUNDS = {
    "greater_than": ("more than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}


def message(errors: Sequence[ErrorDetails], text: str) -> str:
    """What the value at one path should be, from the errors of all alternatives that it was tried as; `text` is the
    value as written, empty for lists and mappings."""
    first = errors[0]
    kind, context = first["type"], first.get("ctx", {})
    if kind in _BOUNDS:
        words, key = _BOUNDS[kind]
        return f"should be {words} {context[key]:g}"
    if kind == "too_short":
        return f"needs at least {_entries(context['min_length'])}, and has {context['actual_length']}"
    if kind == "too_long":
        return f"takes at most {_entries(context['max_length'])}, and has {context['actual_length']}"
    if kind == "missing":
        return "has too few entries"
    names = [name for error in errors for name in _literals(error)]
    kinds = [_KINDS[error["type"]] for error in errors if error["type"] in _KINDS]
    expected = [*(f"`{name}`" for name in names), *kinds]
    if not expected:
        return "has no such form here"
    return f"should be {_either(list(dict.fromkeys(expected)))}{did_you_mean(text, names) if text else ''}"


def _literals(error: ErrorDetails) -> list[str]:
    """The words of which one was expected."""
    if error["type"] != "literal_error":
        return []
    words = str(error.get("ctx", {})["expected"]).replace(" or ", ", ").split(", ")
    return [word.strip("'") for word in words]


def _entries(count: int) -> str:
    return "1 entry" if count == 1 else f"{count} entries"


def _either(options: list[str]) -> str:
    return options[0] if len(options) == 1 else f"{', '.join(options[:-1])} or {options[-1]}"
