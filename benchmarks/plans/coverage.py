"""What plans cover, beside rejection on the same workload: cases, freedom to turn, cells reached, honest shares.

    python -m benchmarks.plans.coverage [--sizes 5,10,20,30,60,80] [--seeds 2] [--diversity 1] [--samples 20000]
    [--plans DIR]

Rejection draws a yaw, then a position on the table, for each box: all at once (N up to 10, the exact distribution), or
box by box with up to 60 tries (N up to 30), with exact oriented boxes and relations; beyond it is not tried. CPU
seconds of one process.
Exit code 1 when a drawn scene is invalid.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from pathlib import Path
from statistics import median
from typing import Any, cast

import numpy as np
from numpy.random import Generator
from scipy.stats import ks_2samp

from benchmarks.plans.rejection import filled
from benchmarks.scenes.workload import TABLE_M, sizes_and_pairs, workload
from runtime_plan import Plan, prepare, sample
from scenec.check.judge_scene import violations
from scenec.ir.problem import Placement, Solved
from scenec.plan.cases.signature import signature
from scenec.plan.document import plan_text
from scenec.plan.document import runtime_plan as plan_of
from scenec.solve import solve
from schemas.scene.program import SceneProgram

CELL_M = 0.05  # of the table, for coverage
COARSE_M = 0.10  # of the table, for occupancy
JOINT = 10  # up to here rejection is joint, and exact
REFERENCE = 30  # up to here rejection is tried
CHECKED = 60
MORE = 10  # draws of the plan for each of rejection: what can be reached, whatever chance leaves out
TRIES = 60


def planned(n: int, seed: int, diversity: float):
    """(problem, plan, text, CPU seconds without solving); None where there is no scene."""
    problem = workload(n, seed)
    result = solve(problem, 0)
    if not isinstance(result, Solved):
        return None
    since = time.process_time()
    program = SceneProgram(scene=problem.scene, clearance=problem.clearance_m)
    plan = plan_of(program, [problem], [result], diversity=diversity)
    seconds = time.process_time() - since
    return problem, prepare(plan), plan_text(plan), seconds


def drawn(plan: Plan, n: int, count: int) -> np.ndarray:
    """(count, n, 3) x, y, yaw of box 0 to n - 1 in samples of a plan."""
    samples = sample(plan, count, 0)
    columns = [samples.names.index(f"box{i}") for i in range(n)]
    return np.concatenate([samples.position_m[:, columns, :2], samples.yaw_rad[:, columns, None]], axis=-1)


def rejected(n: int, seed: int, rng: Generator, count: int, tries: int) -> np.ndarray:
    """(count, n, 3) poses by rejection: `tries` 1 draws whole scenes, more seat box by box, the largest first."""
    sizes, pairs = sizes_and_pairs(n, seed)
    order = np.argsort(-sizes.prod(axis=1)).tolist()
    batches: list[np.ndarray] = []
    while sum(map(len, batches)) < count:
        batches.append(filled(sizes, pairs, order, rng, 100_000 if tries == 1 else 1500, tries))
    return np.concatenate(batches)[:count]


def cells(poses: np.ndarray, side_m: float) -> np.ndarray:
    """(count, n) number of the square of the table in which each box has its middle."""
    at = np.floor((poses[..., :2] + np.array(TABLE_M) / 2) / side_m).astype(int)
    return at[..., 0] * 1000 + at[..., 1]


def coverage(plan: np.ndarray, reference: np.ndarray) -> tuple[float, float, float]:
    """The share of the 5 cm squares reached by rejection that the plan reaches too: least and median box, all boxes."""
    mine, theirs = cells(plan, CELL_M), cells(reference, CELL_M)
    both = [len(set(mine[:, i]) & set(theirs[:, i])) for i in range(plan.shape[1])]
    asked = [len(set(theirs[:, i])) for i in range(plan.shape[1])]
    shares = [found / of for found, of in zip(both, asked, strict=True)]
    return min(shares), median(shares), sum(both) / sum(asked)


def invalid(problem, poses: np.ndarray) -> int:
    return sum(
        bool(
            violations(
                problem, {f"box{i}": Placement(float(x), float(y), float(yaw), 0) for i, (x, y, yaw) in enumerate(pose)}
            )
        )
        for pose in poses[:: max(1, len(poses) // CHECKED)]
    )


def occupancy(one: np.ndarray, two: np.ndarray) -> float:
    """Mean over boxes of half the summed difference of shares of 10 cm squares (total variation)."""
    differences = []
    for i in range(one.shape[1]):
        a, b = (Counter(cells(poses, COARSE_M)[:, i].tolist()) for poses in (one, two))
        differences.append(sum(abs(a[k] / len(one) - b[k] / len(two)) for k in a.keys() | b.keys()) / 2)
    return float(np.mean(differences))


def distances(poses: np.ndarray) -> np.ndarray:
    """Distances of the middles of all pairs of boxes in all scenes."""
    i, j = np.triu_indices(poses.shape[1], 1)
    return np.hypot(*np.moveaxis(poses[:, i, :2] - poses[:, j, :2], -1, 0)).ravel()


def distribution_distance(one: np.ndarray, two: np.ndarray) -> float:
    """The statistic of Kolmogorov and Smirnov: the largest difference of two cumulative distributions."""
    return cast(Any, ks_2samp(one, two)).statistic  # scipy declares the result as a bare tuple


def bias(name: str, poses: np.ndarray, reference: np.ndarray) -> None:
    ks = [
        [distribution_distance(poses[:, i, axis], reference[:, i, axis]) for axis in (0, 1)]
        for i in range(poses.shape[1])
    ]
    apart = distribution_distance(distances(poses[:4000]), distances(reference[:4000]))
    print(
        f"    {name:22} KS of x {np.mean(ks, axis=0)[0]:.3f} (worst {np.max(ks, axis=0)[0]:.3f}), "
        f"of y {np.mean(ks, axis=0)[1]:.3f} ({np.max(ks, axis=0)[1]:.3f}), of pair distances {apart:.3f}, "
        f"occupancy of 10 cm squares differs by {occupancy(poses, reference):.3f}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", default="5,10,20,30,60,80")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--diversity", type=float, default=1.0)
    parser.add_argument("--samples", type=int, default=20_000)
    parser.add_argument("--plans", type=Path, help="Write each plan there as plan-N-SEED.json, for `mana plan`.")
    given = parser.parse_args()
    wrong = 0
    print(
        "  n seed  cases distinct  plan s     bytes  turn rad  5 cm squares of rejection (least, median, all)  invalid"
    )
    for n in map(int, given.sizes.split(",")):
        for seed in range(given.seeds):
            made = planned(n, seed, given.diversity)
            if made is None:
                print(f"{n:3} {seed:4}  no scene")
                continue
            problem, plan, text, seconds = made
            if given.plans is not None:
                given.plans.mkdir(parents=True, exist_ok=True)
                (given.plans / f"plan-{n}-{seed}.json").write_text(text)
            pools = plan.document.combinations[0].pools
            cases = [case for pool in pools for case in pool.cases]
            distinct = {signature(pool.things, case) for pool in pools for case in pool.cases}
            turn = median(sum(b - a for a, b in yaws) * 1e-6 for case in cases for yaws in case.yaws_urad)
            rng = np.random.default_rng([n, seed])
            poses = drawn(plan, n, given.samples)
            bad = invalid(problem, poses)
            wrong += bad
            words, reference = "(rejection not tried)", None
            if n <= REFERENCE:
                reference = rejected(
                    n, seed, rng, given.samples if n <= JOINT else given.samples // 10, 1 if n <= JOINT else TRIES
                )
                words = " ".join(f"{share:.3f}" for share in coverage(poses, reference))
            families = dict(Counter(case.family for case in cases))
            print(
                f"{n:3} {seed:4} {len(cases):6} {len(distinct):8} {seconds:7.2f} {len(text):9} {turn:10.2f}  "
                f"{words:>30}  {bad}/{CHECKED}  {families}",
                flush=True,
            )
            if reference is not None and n <= JOINT:
                again = rejected(n, seed, rng, given.samples, 1)
                more = drawn(plan, n, MORE * given.samples)
                for words, other in (("rejection, drawn again", again), (f"plan, {MORE} times as many", more)):
                    shares = " ".join(f"{share:.3f}" for share in coverage(other, reference))
                    print(f"    {words:22} reaches of the squares of rejection {shares}")
                bias("rejection, drawn again", again, reference)
                bias("plan", poses, reference)
    raise SystemExit(1 if wrong else 0)


if __name__ == "__main__":
    main()
