"""Suggests variant choices to drop: those without which every remaining combination compiled."""

from __future__ import annotations

from collections.abc import Sequence

from scenec.bind.variants import AS_WRITTEN
from schemas.scene.compiled import CombinationVerdict, Suggestion


def dropped_choices(rows: Sequence[CombinationVerdict]) -> tuple[Suggestion, ...]:
    """Edits that drop one candidate or variant, after which every remaining combination has a scene already (`rows` are
    all combinations). None where no single choice is to blame, or where it is the authored value itself.
    """
    failed = [row.combination for row in rows if row.verdict != "compiled"]
    if not failed:
        return ()
    shared = {key: value for key, value in failed[0].items() if all(other.get(key) == value for other in failed)}
    to_blame = [
        (key, value)
        for key, value in shared.items()
        if value != AS_WRITTEN and any(row.combination.get(key) != value for row in rows)
    ]
    return tuple(Suggestion(edit=_words(key, value), verified=True) for key, value in to_blame)


def _words(key: str, value: str) -> str:
    area, _, name = key.partition(".")
    if area == "variants":
        return f"drop {value} of {key}"
    return f"drop candidate {value} of {name or area}"
