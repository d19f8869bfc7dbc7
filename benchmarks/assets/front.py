"""Which side of a thing is its front, beside what the eye sees.

    python -m benchmarks.assets.front ASSETS_DIR

`front_truth.csv` says by eye which horizontal axis is the front of an object that stands with `up_axis` up; nothing
where none is meant. It was written before the first run. The category is the one in the table.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections import Counter
from pathlib import Path

import numpy as np

from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.parts.find import find_parts
from assetkit.pose.front import front_of
from benchmarks.assets.truth_files import located, object_of
from geom.features.cavities import find_cavities
from schemas.evidence import declared, default

TABLE = Path(__file__).with_name("front_truth.csv")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    given = parser.parse_args()
    ends: Counter[str] = Counter()
    with TABLE.open(encoding="utf-8") as file:
        for truth in csv.DictReader(file):
            ends[_asked(truth, *located(given.assets, truth["path"]))] += 1
    print(", ".join(f"{n} {end}" for end, n in sorted(ends.items())))


def _asked(truth: dict[str, str], file: Path, root: Path) -> str:
    options = Options.model_validate({"up_axis": truth["up_axis"]})
    item = object_of(file, options, root)
    made = canonicalize(item, file.name, options).value
    assert made is not None, f"{file} is not refused"
    category = declared(truth["category"], "table") if truth["category"] else default("unknown")
    meshes = {mesh.id: mesh for mesh in made.meshes}
    cavities = find_cavities(made.solid)
    parts = find_parts(meshes, item.model.materials, category, cavities=cavities).parts
    started = time.process_time()
    estimate = front_of(meshes, category, parts, cavities)
    seconds = time.process_time() - started
    sign = -1.0 if truth["front"].startswith("-") else 1.0
    true = sign * np.eye(3)["xyz".index(truth["front"][-1])] if truth["front"] else None
    if estimate.direction.confidence == 0.0:
        end = "unknown" if true is not None else "rightly none"
    else:
        end = "right" if true is not None and np.dot(estimate.direction.value, true) > np.cos(np.pi / 12) else "wrong"
    why = "; ".join(estimate.direction.inputs) or estimate.direction.method
    symmetry = estimate.symmetry.value
    print(f"{truth['path'][-58:]:58} {truth['front']:3} {end:12} symmetry {symmetry}  {seconds:.2f} s  {why}")
    return end


if __name__ == "__main__":
    main()
