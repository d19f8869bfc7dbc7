"""Parts of household things in one shell, whose true parts are known to the triangle; the category is stated.

    python -m benchmarks.assets.made_parts [--seed N] [--draws N] [--turned] [--only TEXT]

A part is found when its label is right and its surface covers at least half of the union with the true one. An
object in one part has none: each label but `body` is wrong there. `--turned` turns everything by random rotations.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from assetkit.parts.find import find_parts
from benchmarks.assets.made_things import Thing, things
from geom.features.cavities import find_cavities
from geom.mesh.surface_distance import triangle_areas
from schemas.arrays import BoolArray, FloatArray
from schemas.evidence import declared
from schemas.model import Mesh
from schemas.physics import Solid

OVERLAP = 0.5


class Row(NamedTuple):
    """One object: true parts and those found, wrong labels, CPU seconds for parts."""

    name: str
    asked: int
    found: int
    wrong: list[str]
    missed: list[str]
    seconds: float


def rows(seed: int, draws: int, *, turned: bool, only: str = "") -> Iterator[Row]:
    rng = np.random.default_rng(seed)
    for thing in things(seed, draws):
        R = Rotation.random(rng=rng).as_matrix() if turned else np.eye(3)
        if only in thing.name:
            yield _row(thing, thing.points @ R.T)


def _row(thing: Thing, points: FloatArray) -> Row:
    mesh = Mesh("thing", points, thing.triangles)
    cavities = find_cavities(Solid(points, thing.triangles, "closed"))
    started = time.process_time()
    found = find_parts({"thing": mesh}, (), declared(thing.category, "table"), cavities=cavities).parts
    seconds = time.process_time() - started
    area = triangle_areas(points[thing.triangles])
    asked = [(label, thing.owner == i) for i, label in enumerate(thing.parts)] if len(thing.parts) > 1 else []
    asked = [(label, piece) for label, mask in asked for piece in _apart(thing, mask, label)]
    left, wrong = list(asked), []
    for part in (p.value for p in found):
        if part.label.confidence <= 0.0 or (not asked and part.label.value == "body"):
            continue
        mask = part.mask("thing", len(thing.triangles))
        near = [
            (float(area[mask & true].sum() / area[mask | true].sum()), i)
            for i, (label, true) in enumerate(left)
            if label == part.label.value
        ]
        best, index = max(near, default=(0.0, -1))
        if best >= OVERLAP:
            del left[index]
        else:
            wrong.append(f"{part.label.value} ({best:.2f})")
    return Row(thing.name, len(asked), len(asked) - len(left), wrong, [label for label, _ in left], seconds)


def _apart(thing: Thing, mask: BoolArray, label: str) -> list[BoolArray]:
    """Handles on two sides are two parts; everything else of one label is one."""
    if thing.name != "pot with two handles" or label != "handle":
        return [mask]
    side = thing.points[thing.triangles].mean(axis=1)[:, 0] > 0.0
    return [mask & side, mask & ~side]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--draws", type=int, default=4)
    parser.add_argument("--turned", action="store_true")
    parser.add_argument("--only", default="")
    given = parser.parse_args()
    table: dict[str, list[Row]] = {}
    for row in rows(given.seed, given.draws, turned=given.turned, only=given.only):
        table.setdefault(row.name, []).append(row)
    for name, group in table.items():
        asked, found = sum(r.asked for r in group), sum(r.found for r in group)
        notes = sorted(
            {*(f"missed {m}" for r in group for m in r.missed), *(f"wrong {w}" for r in group for w in r.wrong)}
        )
        print(f"{name:22} {found:3}/{asked:<3} {max(r.seconds for r in group):5.2f} s  {'; '.join(notes)}")
    every = [row for group in table.values() for row in group]
    asked, found, wrong = (sum(v) for v in zip(*((r.asked, r.found, len(r.wrong)) for r in every), strict=True))
    seconds = sorted(r.seconds for r in every)
    print(f"{len(every)} things, recall {found} of {asked}, precision {found} of {found + wrong}")
    print(f"CPU: median {seconds[len(seconds) // 2]:.2f} s, slowest {seconds[-1]:.2f} s a thing")


if __name__ == "__main__":
    main()
