"""Signature of a case: names of its things and planar bounds rounded to 0.1 mm; equal ones are the same case."""

from __future__ import annotations

from collections.abc import Sequence

from schemas.scene.runtime_plan import PlanCase

ROUNDED_UM = 100  # 1e-4 m

Signature = tuple[tuple[object, ...], ...]


def signature(names: Sequence[str], case: PlanCase) -> Signature:
    """Sorted names, each with its stance, the four bounds of its cell and, where given, of its origin."""
    return tuple(
        sorted(
            (name, stance, *_rounded(cell), *(() if origins is None else _rounded(origins)))
            for name, stance, cell, origins in zip(names, case.stances, case.cells_um, case.origins_um, strict=True)
        )
    )


def _rounded(bounds_um: Sequence[int]) -> tuple[int, ...]:
    return tuple(round(v / ROUNDED_UM) for v in bounds_um)


def distinct(names: Sequence[str], cases: Sequence[PlanCase]) -> list[PlanCase]:
    """The cases without duplicates, the first of each."""
    return list({signature(names, case): case for case in reversed(cases)}.values())[::-1]
