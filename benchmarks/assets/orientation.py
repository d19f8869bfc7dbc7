"""How often an object ends upright: in the pose of its file, and turned without information on its up axis.

    python -m benchmarks.assets.orientation ASSETS_DIR [--only TEXT] [--turns N]

`orientation_truth.csv` says by eye which axis of the file points up when the thing stands in its reference pose,
several when both ways are right; nothing where no way up is meant. It was written before the first run. Each object is
estimated as it is, and `N` times turned: by rotations of the cube, and by any rotation; its up axis is unknown then.
All that once with the category that its names indicate, if any, and once without names. `unsure`: no direction is
probable enough, so the object would stay as it is; `alike`: wrong, but on record as looking like the right one.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from assetkit.annotate.embedded import EmbeddedAnnotator
from assetkit.annotate.name_reading import category_by_name
from assetkit.annotate.observe import observe
from assetkit.geometry.canonical_model import canonicalize
from assetkit.options import Options
from assetkit.pose.up_axis import TO_Z_UP
from assetkit.pose.upright import least_probability, rank_upright
from assetkit.stage import Canonical, Draft
from assetkit.taxonomy.tables import Category
from benchmarks.assets.truth_files import largest, roots
from geom.features.upright_directions import upright_features
from schemas.arrays import FloatArray
from schemas.physics import Solid

TABLE = Path(__file__).with_name("orientation_truth.csv")
RIGHT_RAD = np.radians(15.0)
SEED = 20261122
AXES = {sign + axis: (1 - 2 * (sign == "-")) * np.eye(3)[i] for sign in ("", "-") for i, axis in enumerate("xyz")}


class Case(NamedTuple):
    """One question and what became of it; `best` is the likeliest way up, with its chance."""

    path: str
    kind: str
    end: str
    best: str
    chance: float
    seconds: float


def cases(assets: Path, only: str, turns: int) -> Iterator[Case]:
    rng = np.random.default_rng(SEED)
    with TABLE.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            draws = [("cube", Rotation.create_group("O").as_matrix()[i]) for i in rng.integers(24, size=turns)]
            draws += [("any", R) for R in Rotation.random(turns, rng=rng).as_matrix()]
            root = roots(assets)[row["root"]]
            made = canonical_of(root / row["path"], root) if only in row["path"] else None
            if made is not None:
                yield from _asked(row["path"], row["up"], made, draws)


def canonical_of(path: Path, root: Path) -> tuple[Canonical, Category | None] | None:
    """The largest object of a file in its metric frame, and the category by its names; None when it is refused."""
    item = largest(path, Options(), root)
    if item is None:
        return None
    canonical = canonicalize(item, path.name, Options()).value
    if canonical is None:
        return None
    annotation = EmbeddedAnnotator().annotate(observe(Draft("part", path.name, item, canonicalize=canonical)))
    return canonical, category_by_name(annotation.category)


def _asked(
    path: str, truth: str, made: tuple[Canonical, Category | None], draws: list[tuple[str, FloatArray]]
) -> Iterator[Case]:
    canonical, category = made
    ups = [TO_Z_UP[canonical.up_axis.value] @ AXES[axis] for axis in truth.split("|") if axis]
    views = [("as it is", np.eye(3)), *draws]
    for kind, R in views:
        solid = _turned(canonical.solid, R)
        started = time.perf_counter()
        standing = upright_features(solid)
        seconds = time.perf_counter() - started
        for known in dict.fromkeys((category, None)):
            name = f"{kind}, {'named' if known else 'nameless'}"
            given = canonical.up_axis if kind == "as it is" else None
            ranked = rank_upright(standing, known, given)
            best = np.array(ranked[0].up) if ranked else np.array([0.0, 0.0, 1.0])
            sure = bool(ranked) and ranked[0].probability >= least_probability(ranked[0], known, given)
            unchanged = kind == "as it is" and not sure
            right = _is_up(np.array([0.0, 0.0, 1.0]) if unchanged else best, R, ups)
            same = sure and any(_is_up(np.array(up), R, ups) for up in ranked[0].alike)
            end = "right" if right else "alike" if same else "wrong"
            if not (sure or unchanged):
                end = f"unsure ({end})"
            if not ups:
                end = "turned" if sure and best[2] < 0.99 else "left"
            yield Case(path, name, end, str(np.round(best, 2)), ranked[0].probability if ranked else 0.0, seconds)


def _is_up(up: FloatArray, R: FloatArray, ups: Sequence[FloatArray]) -> bool:
    return any(up @ R @ true > np.cos(RIGHT_RAD) for true in ups)


def _turned(solid: Solid, R: FloatArray) -> Solid:
    return replace(solid, points=solid.points @ R.T)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--turns", type=int, default=3)
    arguments = parser.parse_args()
    ends: dict[str, Counter[str]] = defaultdict(Counter)
    known: Counter[str] = Counter()
    last = ""
    for case in cases(arguments.assets, arguments.only, arguments.turns):
        what = f"{case.path[-60:]:60} {case.kind:20} {case.end:15} {case.chance:.2f}"
        print(f"{what} {case.best}  {case.seconds:.2f} s", flush=True)
        ends[case.kind][case.end] += 1
        if case.kind.startswith("as it is") and case.path != last:  # Named first, where a name tells.
            known[case.end] += 1
        last = case.path
    for kind, counts in {"as it is, with what is known": known, **ends}.items():
        print(f"{kind}: {', '.join(f'{n} {end}' for end, n in sorted(counts.items()))}")


if __name__ == "__main__":
    main()
