"""The table of material features of source formats: what each becomes when it is read."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

TREATMENTS = {
    "kept": "a field of the material, as stated",
    "converted": "a field of the material, by a formula; its evidence names both",
    "recorded": "kept as written in `appearance.unmapped` of the record, with `asset/material-extension-fallback`",
}


@dataclass(frozen=True)
class Feature:
    """One feature: the smallest `example` of it, the field or property that it `becomes`, and `how`."""

    format: str
    name: str
    example: str
    becomes: str
    treatment: str
    how: str


def material_features() -> tuple[Feature, ...]:
    """All rows of `material_features.toml`, in its order."""
    table = tomllib.loads((Path(__file__).parent / "material_features.toml").read_text())
    return tuple(Feature(format_name, *row) for format_name, rows in table.items() for row in rows)
