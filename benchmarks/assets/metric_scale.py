"""Error of the estimated size of objects whose unit was removed.

    python -m benchmarks.assets.metric_scale ASSETS_DIR [--only TEXT]

`metric_scale_truth.csv` lists objects of known size. Their numbers are changed to look like those of a file without a
unit: written in m, cm, mm or inches, normalised to a longest edge of 1, or multiplied by any factor (from a seed). Each
is estimated with the category that its names indicate, the object's own row (`own_anchor`) taken out of the things of
known size, and without names. `in review` goes to a person, with bounds; `accepted` ones are counted on their own.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from assetkit.annotate.annotator import ObjectShape, Observation
from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.name_reading import category_by_name
from assetkit.options import METERS_PER_UNIT, Options
from assetkit.scale.declared_units import decide_unit
from assetkit.scale.metric_scale import estimate_scale, is_normalised
from assetkit.scale.size_prior import CATEGORY_PRECISION
from assetkit.stage import Intake
from assetkit.taxonomy.tables import Category
from benchmarks.assets.truth_files import object_of, roots
from geom.convex.primitive_fits import fit_box
from schemas.arrays import FloatArray
from schemas.evidence import Evidence, default

TABLE = Path(__file__).with_name("metric_scale_truth.csv")
SEED, SPREAD = 20261122, 1.5
ROUNDING = 1e-6


class Answer(NamedTuple):
    """One question: `error` is the factor by which the size is off, less one; `inside` whether the bounds hold it."""

    path: str
    numbers: str
    category: str
    error: float
    inside: bool
    width: float
    review: bool


def answers(assets: Path, only: str = "") -> Iterator[Answer]:
    rng = np.random.default_rng(SEED)
    with TABLE.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            odd = math.exp(rng.normal(0.0, SPREAD))
            if only not in row["path"]:
                continue
            root = roots(assets)[row["root"]]
            path = root / row["path"]
            item = object_of(path, Options(), root)
            points = np.concatenate([m.points for m in item.model.meshes]) * float(row["meters_per_unit"])
            extent_m = np.ptp(points, axis=0)
            box = fit_box(points)
            edges_m = np.sort(box.size_m if box is not None else extent_m)
            written = {unit: 1.0 / scale for unit, scale in METERS_PER_UNIT.items()}
            written |= {"normalised": 1.0 / float(extent_m.max()), "any factor": odd}
            named = _category(path, item, edges_m)
            for numbers, factor in written.items():
                for category in dict.fromkeys((named, None)):
                    evidence, review = _asked(item, extent_m * factor, edges_m * factor, category, row["own_anchor"])
                    low, high = evidence.bounds or (evidence.value, evidence.value)
                    inside = low * factor <= 1.0 + ROUNDING and high * factor >= 1.0 - ROUNDING
                    off = evidence.value * factor
                    yield Answer(
                        row["path"],
                        numbers,
                        category.id if category else "",
                        max(off, 1 / off) - 1,
                        inside,
                        high / low,
                        review,
                    )


def _category(path: Path, item: Intake, edges_m: FloatArray) -> Category | None:
    """What the names say it is; of the shape only the proportions are known."""
    small, middle, large = (float(e) for e in edges_m)
    nodes = tuple(m.name for m in item.model.meshes if m.name)
    materials = tuple(m.name for m in item.model.materials if m.name)
    shape = ObjectShape((small, middle, large), None, None, metric=False)
    return category_by_name(
        EmbeddedAnnotator().annotate(Observation(path.stem, item.folders, nodes, materials, (), shape)).category
    )


def _asked(
    item: Intake, extent: FloatArray, edges: FloatArray, category: Category | None, without: str
) -> tuple[Evidence[float], bool]:
    """The scale that the pipeline estimates, and whether a person has to review it."""
    x, y, z = (float(e) for e in extent)
    if category is None and not is_normalised((x, y, z)):
        decision = decide_unit(stated=default(1.0), extent=(x, y, z), format_=item.format)
        return decision.meters_per_unit, decision.review
    scale = estimate_scale(
        (x, y, z), edges.tolist(), category, CATEGORY_PRECISION, format_=item.format, excluded_anchor=without
    )
    return scale.meters_per_unit, scale.review


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    groups: dict[str, list[Answer]] = defaultdict(list)
    for a in answers(arguments.assets, arguments.only):
        end = "review" if a.review else ""
        mark = "" if a.inside else "OUTSIDE"
        print(f"{a.path[-50:]:50} {a.numbers:11} {a.category:13} {a.error:8.1%} {a.width:6.3g}x {mark:8}{end}")
        kind = "named" if a.category else "nameless"
        for title in (f"{kind}, {a.numbers}", f"{kind}, all", *([] if a.review else [f"{kind}, accepted"])):
            groups[title].append(a)
    for title in sorted(groups):
        table = groups[title]
        errors = sorted(a.error for a in table)
        far = sum(a.error > 0.15 and not a.review for a in table)
        print(
            f"{title}: {len(table)} asked, median error {errors[len(errors) // 2]:.1%}, inside the bounds "
            f"{sum(a.inside for a in table) / len(table):.0%}, in review {sum(a.review for a in table)}, "
            f"accepted and more than 15 % off {far}"
        )


if __name__ == "__main__":
    main()
