"""The SQL of one search criterion: keys and confidences (above 0) of the assets that match it.

The rules are those of `assetkit.library.search.match`; a law test holds both against each other.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence

from assetkit.annotate.annotator import UNKNOWN
from assetkit.annotate.name_reading import category_by_name
from assetkit.library.catalog.listing import vocabulary
from assetkit.library.search.match import (
    ANCHOR_OF_TASK,
    BY_ANCHOR,
    FAINT_COLOUR,
    HYPOTHESIS,
    NOT_CONTRADICTED,
    PLACEHOLDER_FIGURE,
    USUAL_PART,
)
from assetkit.library.search.query import Criterion

Sql = tuple[str, list[str | float]]
# Confidence of a word by the column of texts that contains it, highest first: names are given by people, for reasons.
TEXT_CONFIDENCE = {"names": 0.6, "others": 0.5, "source_texts": 0.4, "aliases": 0.4}
_FIGURES = {
    "size_m": ("longest_m", "extent_confidence"),
    "height_m": ("size_z_m", "extent_confidence"),
    "mass_kg": ("mass_kg", "mass_confidence"),
}


def criterion_sql(db: sqlite3.Connection, criterion: Criterion) -> Sql:
    """A query with the columns `key` and `confidence`, and its values; of two rows of an asset the higher counts."""
    sql, values = _positive(db, criterion)
    if not criterion.negated:
        return sql, values
    known = _known(criterion)
    others = f"SELECT key, {NOT_CONTRADICTED} AS confidence FROM assets WHERE {known}"
    return f"{others} AND key NOT IN (SELECT key FROM ({sql}))", values


def match_expression(column: str, words: Sequence[str], criterion: Criterion) -> str:
    """The full-text expression for any of some words in a column."""
    prefix = "" if criterion.negated else "*"
    quoted = (word.replace('"', '""') for word in words)
    return f"{column} : ({' OR '.join(f'{chr(34)}{word}{chr(34)}{prefix}' for word in quoted)})"


def _positive(db: sqlite3.Connection, criterion: Criterion) -> Sql:
    match criterion.field:
        case "category":
            return _category(criterion)
        case "family" | "role" | "material" | "outcome":
            return _trait(criterion.field, criterion.values)
        case "colour":
            return _trait("colour", criterion.values, least=FAINT_COLOUR)
        case "size_m" | "height_m" | "mass_kg":
            column, confidence = _FIGURES[criterion.field]
            sql = f"SELECT key, max({confidence}, {PLACEHOLDER_FIGURE}) AS confidence FROM assets"
            return f"{sql} WHERE {column} BETWEEN ? AND ?", [criterion.low, criterion.high]
        case "anchor":
            return _trait("anchor", criterion.values[:1])
        case "task":
            return _task(db, criterion.values[0])
        case "part":
            return _part(db, criterion.values[0])
        case "text":
            sql = "SELECT rowid AS key, {} AS confidence FROM words WHERE words MATCH ?"
            parts = [sql.format(confidence) for confidence in TEXT_CONFIDENCE.values()]
            values = [match_expression(column, criterion.values, criterion) for column in TEXT_CONFIDENCE]
            return " UNION ALL ".join(parts), [*values]


def _known(criterion: Criterion) -> str:
    """The condition that an asset has another recorded value, so that a negated criterion can hold."""
    match criterion.field:
        case "category" | "family" | "role" | "material" | "outcome" | "colour":
            other = f"t.field = '{criterion.field}' AND t.value <> '{UNKNOWN}'"
            return f"EXISTS (SELECT 1 FROM traits t WHERE t.key = assets.key AND {other})"
        case "task":
            return "1" if criterion.values[0] in ANCHOR_OF_TASK else "0"
        case "part":
            return "0"
        case _:
            return "1"


def _trait(field: str, values: Sequence[str], *, least: float = 0.0, factor: float = 1.0) -> Sql:
    """Assets with one of the values in a field of `traits`; `factor` scales their confidence."""
    scaled = "confidence" if factor == 1.0 else f"{factor} * confidence AS confidence"
    sql = f"SELECT key, {scaled} FROM traits WHERE field = ? AND value IN ({_marks(values)}) AND confidence > 0"
    return f"{sql} AND traits.confidence >= {least}", [field, *values]


def _category(criterion: Criterion) -> Sql:
    """By the category; where that is unknown also by the likeliest hypothesis, unless only stated values count."""
    sql, values = _trait("category", criterion.values)
    if criterion.stated:
        return sql, values
    likely, more = _trait("hypothesis", criterion.values, factor=HYPOTHESIS)
    is_unknown = f"t.field = 'category' AND t.value = '{UNKNOWN}'"
    likely += f" AND EXISTS (SELECT 1 FROM traits t WHERE t.key = traits.key AND {is_unknown})"
    return f"{sql} UNION ALL {likely}", [*values, *more]


def _task(db: sqlite3.Connection, task: str) -> Sql:
    """By recorded affordances; where none is about the task, by the anchor that the task needs."""
    texts = [text for text in vocabulary(db, "task") if task in text]
    sql, values = _trait("task", texts)
    if task not in ANCHOR_OF_TASK:
        return sql, values
    anchor, more = _trait("anchor", (ANCHOR_OF_TASK[task],), factor=BY_ANCHOR)
    about = f"t.field = 'task' AND t.value IN ({_marks(texts)})"
    anchor += f" AND NOT EXISTS (SELECT 1 FROM traits t WHERE t.key = traits.key AND {about})"
    return f"{sql} UNION ALL {anchor}", [*values, *more, *texts]


def _part(db: sqlite3.Connection, part: str) -> Sql:
    """By recorded parts and affordances, for certain; else by the parts that things of the category usually have."""
    named = [_named(field, [v for v in vocabulary(db, field) if part in v.lower()]) for field in ("part", "task")]
    known = [(value, category_by_name(value)) for value in vocabulary(db, "category")]
    usual = [value for value, category in known if category is not None and part in category.parts]
    parts = [*named, _trait("category", usual, factor=USUAL_PART)]
    return " UNION ALL ".join(sql for sql, _ in parts), [value for _, values in parts for value in values]


def _named(field: str, values: Sequence[str]) -> Sql:
    sql = f"SELECT key, 1.0 AS confidence FROM traits WHERE field = ? AND value IN ({_marks(values)})"
    return sql, [field, *values]


def _marks(values: Sequence[str]) -> str:
    return ",".join("?" * len(values))
