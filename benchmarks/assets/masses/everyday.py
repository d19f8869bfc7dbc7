"""Compares mass bounds of compact objects of unknown material with their true masses.

    python -m benchmarks.assets.masses.everyday

`everyday_masses.csv` holds common objects as closed boxes, cylinders (diameter, height) and balls, with the source of
each mass: rules of games, standards, the YCB set, density times volume, sheets of makers. The pipeline does
not get their names. Each is estimated twice: from the shape alone, and with metallic surfaces where the metal is bare.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from geom.convex.support_function import surface
from schemas.physics import CollisionShape, ShapeKind, Solid

TABLE = Path(__file__).with_name("everyday_masses.csv")
METAL = "metallic surface"


class Thing(NamedTuple):
    """A common object: its outside as a closed solid, whether bare metal shows, and its mass."""

    name: str
    solid: Solid
    bare_metal: bool
    mass_kg: float


def things() -> Iterator[Thing]:
    """The rows of the table."""
    with TABLE.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            size_m = tuple(float(size) / 1000.0 for size in row["size_mm"].split())
            yield Thing(row["name"], _solid(row["shape"], size_m), row["bare_metal"] == "yes", float(row["mass_kg"]))


def bounds_kg(thing: Thing, *, with_metal: bool) -> tuple[float, float]:
    """Mass bounds from the shape; `with_metal` adds the appearance of bare metal."""
    mass_inputs = MassEvidenceInputs(dense_reason=METAL if with_metal and thing.bare_metal else "")
    evidence = mass_evidence(thing.solid, ["thing"], mass_inputs).mass_kg
    return evidence.bounds or (evidence.value, evidence.value)


def main() -> None:
    table = list(things())
    for with_metal in (False, True):
        rows = [(thing, *bounds_kg(thing, with_metal=with_metal)) for thing in table]
        outside = [row for row in rows if not row[1] <= row[0].mass_kg <= row[2]]
        print(f"{'shape and look' if with_metal else 'shape alone'}: {len(rows) - len(outside)} of {len(rows)} inside")
        for thing, low, high in outside:
            side = "heavier" if thing.mass_kg > high else "lighter"
            print(f"  {thing.name:26} {thing.mass_kg:8.4g} kg, {side} than [{low:.4g}, {high:.4g}]")


def _solid(shape: str, size_m: tuple[float, ...]) -> Solid:
    kinds: dict[str, ShapeKind] = {"box": "box", "cylinder": "cylinder", "ball": "sphere"}
    size = size_m if shape == "box" else (size_m[0] / 2.0, *size_m[1:])
    points, triangles = surface(CollisionShape(kinds[shape], size, np.eye(4)))
    return Solid(points, triangles.astype(np.int32), "closed")


if __name__ == "__main__":
    main()
