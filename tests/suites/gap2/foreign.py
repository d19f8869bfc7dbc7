"""The shared foreign recordings as cases of this suite: their `truth.json` in the scorer's terms."""

from __future__ import annotations

import json
from pathlib import Path

from tests.suites.gap2.generate.truth import Family, HiddenEffect, Truth

_FAMILIES: dict[str, Family] = {
    "effect": "single",
    "pair_separable": "twin",
    "pair_inseparable": "twin",
    "two_effects": "two",
    "outside_library": "outside",
}


def foreign_cases(folder: Path) -> list[tuple[Path, Truth]]:
    """(measurement folder, truth) of each case, in order. `accept` and `level_multiple` are the authors' own."""
    listed = json.loads((folder / "truth.json").read_text())["cases"]
    return [(folder / name, _truth(int(name.rpartition("_")[2]), case)) for name, case in sorted(listed.items())]


def _truth(number: int, case: dict) -> Truth:
    family = _FAMILIES.get(case["kind"], "control")
    return Truth(
        number=number,
        measurement="",
        family=family,
        kind=case["measurement_kind"],
        scene=case["scene"],
        effects=tuple(HiddenEffect(name) for name in case["effects"]),
        accept=tuple(case["accept"]),
        near=tuple(case["near"]),
        level=case["level"] or "",
        level_reached=all(case["level_reached"]),
        miss=min(case["level_multiple"], default=case["change_over_floor"]),
        horizon_s=case["horizon_s"],
        twin=case["partner"] or "",
        control=case["kind"] if family == "control" else "",
    )
