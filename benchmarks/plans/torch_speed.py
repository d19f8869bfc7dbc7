"""How fast PyTorch draws from a plan on a device, and whether it draws what numpy does.

    python -m benchmarks.plans.torch_speed PLAN [--device cuda] [--batches 4096,65536]

Exit code 1 when a choice differs, or a pose by more than 1e-6. Wall time of 20 batches after one that does not count.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import fields
from pathlib import Path

import numpy as np

from runtime_plan import Samples, load, sample

CHECKED, SEED = 4096, 2**63 + 5


def difference(one: Samples, two: Samples) -> float:
    """The largest difference of two draws, of which the second holds tensors; inf where a choice differs."""
    worst = 0.0
    for name in (f.name for f in fields(one) if f.name not in ("seed", "start", "names")):
        mine, theirs = getattr(one, name), getattr(two, name).cpu().numpy()
        if mine.dtype.kind != "f":
            worst = worst if np.array_equal(mine, theirs) else np.inf
        elif np.array_equal(np.isnan(mine), np.isnan(theirs)):
            worst = max(worst, float(np.nanmax(np.abs(mine - theirs), initial=0.0)))
        else:
            worst = np.inf
    return worst


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plan", type=Path)
    parser.add_argument("--device", default="cuda")
    parser.add_argument("--batches", default="4096,65536")
    given = parser.parse_args()
    from runtime_plan.torch_sampler import TorchSampler

    plan = load(given.plan)
    sampler = TorchSampler(plan, given.device)
    worst = difference(sample(plan, CHECKED, SEED), sampler.sample(CHECKED, SEED))
    print(f"{CHECKED} samples differ from numpy's by {worst:.1e} at most")
    for batch in map(int, given.batches.split(",")):
        last = sampler.sample(batch, 0)
        last.lighting.sum().item()
        since = time.perf_counter()
        for k in range(20):
            last = sampler.sample(batch, 0, start=k * batch)
        last.position_m[-1].sum().item()  # waits for the device
        seconds = (time.perf_counter() - since) / 20
        print(f"{batch} a batch: {1e3 * seconds:.2f} ms, {batch / seconds:,.0f} scenes/s")
    return 1 if worst > 1e-6 else 0


if __name__ == "__main__":
    raise SystemExit(main())
