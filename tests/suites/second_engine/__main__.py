"""The second engine's figures as a table, of every package in a library.

    python -m tests.second_engine LIBRARY

Each listed pose is set down once and pushed to two sides, and the record's 32 trials are repeated; see
`test_second_engine.py`. Differences are the largest between PyBullet and MuJoCo, from the URDF twin or from the USD.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from pathlib import Path

from assetkit.acceptance.stable_poses import trial_starts
from tests.suites.second_engine import comparison, mujoco_drops
from tests.suites.second_engine.comparison import Pair

HEADINGS = (
    "asset",
    "mass rel err",
    "inertia rel err",
    "poses (curved)",
    "drops",
    "same pose",
    "height diff mm",
    "tilt diff deg",
    "on curved",
    "pushed on curved",
    "trials alike",
)


def main(library: Path) -> None:
    print(*HEADINGS, sep=" | ")
    for folder in sorted(record.parent for record in library.glob("*/record.json")):
        print(*row(folder), sep=" | ", flush=True)


def row(folder: Path) -> list[str]:
    """The cells of one package, formatted."""
    package = comparison.opened(folder)
    down, pushed = comparison.set_down_starts(package), comparison.pushed_starts(package)
    starts = [*down, *pushed]
    answer = comparison.ask_mujoco_usd([package], [starts])[0]
    errors = [comparison.mass_errors(package.record, f) for f in (mujoco_drops.facts(package.urdf), answer["facts"])]
    bullet = comparison.in_bullet(package, starts)
    others = comparison.in_mujoco(package, starts), comparison.in_mujoco_usd(package, answer)
    pairs = [pair for other in others for pair in comparison.pairs(package, bullet, other)]
    trials = trial_starts(package.body)
    alike = comparison.pairs(package, comparison.in_bullet(package, trials), comparison.in_mujoco(package, trials))
    curved = {pair.start for pair in pairs if pair.curved and pair.start < len(down)}
    return [
        folder.name,
        f"{max(e['mass'] for e in errors):.0e}",
        f"{max(e['tensor'] for e in errors):.0e}",
        f"{len(down)} ({len(curved)})",
        str(len(pairs)),
        str(sum(_alike(pair) for pair in pairs)),
        f"{1000.0 * max((pair.height_m for pair in pairs), default=0.0):.3f}",
        _tilt(pair for pair in pairs if not pair.curved),
        _tilt(pair for pair in pairs if pair.curved and pair.start < len(down)),
        _tilt(pair for pair in pairs if pair.curved and pair.start >= len(down)),
        f"{sum(_alike(pair) for pair in alike)}/{len(alike)}",
    ]


def _alike(pair: Pair) -> bool:
    return pair.classes[0] is not None and pair.classes[0] == pair.classes[1]


def _tilt(pairs: Iterable[Pair]) -> str:
    tilts = [math.degrees(pair.tilt_rad) for pair in pairs]
    return f"{max(tilts):.2f}" if tilts else ""


if __name__ == "__main__":
    main(Path(sys.argv[1]))
