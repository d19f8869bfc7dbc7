"""Compares mass bounds of objects with known names with their true masses.

    python -m benchmarks.assets.masses.named_masses [--list]

`named_masses.csv` holds 131 common objects outside the development data as plain shapes: boxes, cylinders and ellipses
(two widths, height), balls, wedges (half of a box), cups (width at the bottom and the top, height, wall); the YCB set
by its published table, the rest by trade sizes and rules, from general knowledge. Each is estimated three times: by
its name, by its name with its own row left out of the prior table (`usual_masses.csv`), and without a name.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from shapely import Polygon

from assetkit.annotate.annotator import Observation
from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.name_reading import category_by_name
from assetkit.annotate.shape_check import shape_of
from assetkit.mass.estimate import mass_evidence
from assetkit.mass.parts import MassEvidenceInputs
from schemas.physics import Solid

TABLE = Path(__file__).with_name("named_masses.csv")
SECTIONS = 64


class Thing(NamedTuple):
    """A common object: its surface as a closed solid, its mass, and the key of its own row in the prior table."""

    name: str
    solid: Solid
    mass_kg: float
    own_row_of: str


class Row(NamedTuple):
    """What was found: bounds (kg) and the category that the name was taken for."""

    thing: Thing
    category: str
    bounds_kg: tuple[float, float]

    @property
    def inside(self) -> bool:
        """Whether the mass is within the bounds."""
        return self.bounds_kg[0] <= self.thing.mass_kg <= self.bounds_kg[1]

    @property
    def width(self) -> float:
        """Upper over lower bound."""
        return self.bounds_kg[1] / self.bounds_kg[0]


def things() -> Iterator[Thing]:
    """The rows of the table."""
    with TABLE.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            size_m = [float(size) / 1000.0 for size in row["size_mm"].split()]
            yield Thing(row["name"], _solid(row["shape"], size_m), float(row["mass_kg"]), row["own_row_of"])


def weighed(thing: Thing, name: str, *, without: str = "") -> Row:
    """Bounds of `thing` when its file is called `name`; `without` names an object whose row is left out."""
    points = thing.solid.points
    seen = Observation(name, (), (), (), (), shape_of(points, thing.solid))
    known = category_by_name(EmbeddedAnnotator().annotate(seen).category)
    mass_inputs = MassEvidenceInputs(
        category=known.id if known else "",
        names=(name,),
        category_range_kg=known.mass_kg if known else None,
        excluded_row=without,
    )
    mass = mass_evidence(thing.solid, [name], mass_inputs).mass_kg
    return Row(thing, mass_inputs.category, mass.bounds or (mass.value, mass.value))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--list", action="store_true", help="every row")
    arguments = parser.parse_args()
    table = list(things())
    named = [weighed(thing, thing.name) for thing in table]
    known = [row for row in named if row.category]
    summary("named, category known", known)
    summary("named, own row left out", [weighed(r.thing, r.thing.name, without=r.thing.own_row_of) for r in known])
    summary("named, category not found", [row for row in named if not row.category])
    summary("without a name", [weighed(thing, "thing") for thing in table])
    for row in named if arguments.list else ():
        low, high = row.bounds_kg
        figures = f"{row.thing.mass_kg:8.4g} kg in [{low:.4g}, {high:.4g}] x{row.width:.1f}"
        print(f"{row.thing.name:28} {row.category or '-':16} {figures} {'' if row.inside else 'OUTSIDE'}")


def summary(title: str, rows: Sequence[Row]) -> None:
    """Share inside and widths, and what lies outside."""
    if not rows:
        return
    mean = math.exp(sum(math.log(row.width) for row in rows) / len(rows))
    inside = sum(row.inside for row in rows)
    widest = max(row.width for row in rows)
    wide = sum(row.width > 10.01 for row in rows)
    share = f"{inside} of {len(rows)} inside ({100 * inside / len(rows):.0f} %)"
    print(f"{title}: {share}, x{mean:.2f} in the geometric mean, x{widest:.1f} at most, {wide} wider than x10")
    outside = (f"{row.thing.name} ({row.thing.mass_kg:g} kg)" for row in rows if not row.inside)
    print(f"  outside: {', '.join(outside) or 'none'}")


def _solid(shape: str, size_m: Sequence[float]) -> Solid:
    mesh = _mesh(shape, size_m)
    return Solid(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int32), "closed")


def _mesh(shape: str, size_m: Sequence[float]) -> trimesh.Trimesh:
    if shape == "box":
        return trimesh.creation.box(size_m)
    if shape == "cylinder":
        return trimesh.creation.cylinder(size_m[0] / 2.0, size_m[1], sections=SECTIONS)
    if shape == "ball":
        return trimesh.creation.icosphere(subdivisions=3, radius=size_m[0] / 2.0)
    if shape == "wedge":
        x, y, z = size_m
        return trimesh.creation.extrude_polygon(Polygon([(0, 0), (y, 0), (0, z)]), x)
    if shape == "ellipse":
        mesh = trimesh.creation.cylinder(0.5, size_m[2], sections=SECTIONS)
        mesh.apply_scale([size_m[0], size_m[1], 1.0])
        return mesh
    bottom, top, height, wall = size_m
    outer, inner = [(0, 0), (bottom / 2, 0), (top / 2, height)], [(top / 2 - wall, height), (bottom / 2 - wall, wall)]
    return trimesh.creation.revolve([*outer, *inner, (0, wall)], sections=SECTIONS)


if __name__ == "__main__":
    main()
