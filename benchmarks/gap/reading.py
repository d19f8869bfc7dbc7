"""Cost of reading a measurement of 540 tosses, beside parsing its tables with NumPy alone.

    python -m benchmarks.gap.reading MEASURED

`MEASURED` is the folder of the shared recordings: real tosses, and the same ones again with noise of 1 mm.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from examples.measured import cube_toss
from examples.measured.folder import Part, write
from simgap.recording.read import read

TRIALS, ROUNDS = 540, 3


def tosses(measured: Path) -> Part:
    """Real tosses, and noisy copies of them up to `TRIALS`."""
    part, rng = cube_toss.parts(measured / "cube_toss")[0], np.random.default_rng(0)
    more = {
        f"{name}_b": {n: v + rng.normal(0.0, 1e-3, v.shape) * (n[0] == "p") for n, v in columns.items()}
        for name, columns in part.tables.items()
    }
    return part._replace(tables=dict(list({**part.tables, **more}.items())[:TRIALS]))


def least_cpu_s(task: Callable[[], Any]) -> float:
    """Processor seconds of the fastest of some rounds."""
    costs = []
    for _ in range(ROUNDS):
        started = time.process_time()
        task()
        costs.append(time.process_time() - started)
    return min(costs)


def main() -> None:
    """Print both costs and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder), tosses(given.measured))
        files = sorted(Path(folder).rglob("*.csv"))
        ours = least_cpu_s(lambda: read(Path(folder)))
        parsed = least_cpu_s(lambda: [np.loadtxt(file, delimiter=",", skiprows=1) for file in files])
    figures = f"read and checked {ours:.2f} s, parsed by NumPy alone {parsed:.2f} s, ratio {ours / parsed:.1f}"
    print(f"{len(files)} tables: {figures}")


if __name__ == "__main__":
    main()
