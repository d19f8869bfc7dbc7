"""How fast scenes are drawn from plans, and from what plans are drawn elsewhere by rejection, in the same run.

    python -m benchmarks.plans.speed [--sizes 5,10,30,60,80] [--batch 4096] [--check 20000] [--limit 10]

The workload of the anchors: boxes of 4 to 14 cm, free yaw, 1 cm clearance, N/5 `left_of` pairs. CPU seconds of one
thread (set OMP_NUM_THREADS=1). Below each plan stand those that reject: the same boxes in the same order, 200 tries a
box, by oriented boxes in numpy (many scenes at once), compiled by numba, and by scene_synthesizer. The last two are no
dependencies of Mana and take part where they are installed: pip install -c constraints.txt numba scene-synthesizer.
The independent judge looks at up to --check scenes of each but numpy's; exit code 1 when one of a plan is invalid.
"""

from __future__ import annotations

import argparse
import time
from importlib import import_module
from importlib.util import find_spec

import numpy as np

from benchmarks.plans.rejection import filled
from benchmarks.scenes.workload import sizes_and_pairs, workload
from runtime_plan import Plan, prepare, sample
from runtime_plan.verify import Judge
from scene_check.batch import BatchPoses
from scene_check.check_batch import check_batch
from scene_check.from_plan import scene_rules
from scenec.ir.problem import Solved
from scenec.plan.document import plan_text
from scenec.plan.document import runtime_plan as plan_of
from scenec.solve import solve
from schemas.scene.program import SceneProgram

TRIES = 200
ELSEWHERE = {"numba": "benchmarks.plans.numba_rejection", "scene_synthesizer": "benchmarks.plans.synthesizer_rejection"}
Pairs = list[tuple[int, int]]


def plan_for(n: int) -> tuple[Plan, float, int]:
    """The plan of n boxes, CPU seconds to make it, bytes of its file."""
    since = time.process_time()
    problem = workload(n, 0)
    solved = solve(problem, 0)
    assert isinstance(solved, Solved), "the workload has a scene"
    document = plan_of(SceneProgram(scene=f"workload{n}"), [problem], [solved])
    return prepare(document), time.process_time() - since, len(plan_text(document))


def rate(plan: Plan, batch: int) -> float:
    """Scenes per CPU second in batches, the best of five runs of about a quarter of a second each."""
    sample(plan, batch, 0)
    best = 0.0
    for run in range(5):
        since, count = time.process_time(), 0
        while time.process_time() - since < 0.25:
            sample(plan, batch, run, start=count)
            count += batch
        best = max(best, count / (time.process_time() - since))
    return best


def latency_ms(plan: Plan) -> tuple[float, float]:
    """Median and 99th percentile of CPU milliseconds for one scene."""
    times = []
    for k in range(500):
        since = time.process_time_ns()
        sample(plan, 1, 0, start=k)
        times.append((time.process_time_ns() - since) / 1e6)
    return float(np.median(times)), float(np.percentile(times, 99))


def refused(plan: Plan, poses: np.ndarray) -> int:
    """How many scenes of x, y, yaw (m, n, 3) the independent judge refuses."""
    rules = scene_rules(plan.document, plan.document.combinations[0])
    at = poses[:, [int(thing.name.removeprefix("box")) for thing in rules.things]]
    origin = np.concatenate([at[..., :2], np.zeros((*at.shape[:2], 1))], axis=-1)
    shape = at.shape[:2]
    return sum(
        1 for _ in check_batch(rules, BatchPoses(origin, at[..., 2], np.zeros(shape, int), np.ones(shape, bool)))
    )


def rejection(sizes: np.ndarray, pairs: Pairs, limit_s: float, n: int = 512) -> tuple[float, float]:
    """Scenes per CPU second and the share of attempts that succeed, boxes in the order of the program."""
    rng, since, done, begun = np.random.default_rng(0), time.process_time(), 0, 0
    while time.process_time() - since < limit_s:
        done += len(filled(sizes, pairs, range(len(sizes)), rng, n, TRIES))
        begun += n
    return done / (time.process_time() - since), done / begun


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default="5,10,30,60,80")
    parser.add_argument("--batch", type=int, default=4096)
    parser.add_argument("--check", type=int, default=20_000)
    parser.add_argument("--limit", type=float, default=10.0)
    asked = parser.parse_args()
    present = {name: module for name, module in ELSEWHERE.items() if find_spec(name) is not None}
    print(f"not installed here: {', '.join(sorted(ELSEWHERE.keys() - present.keys())) or 'nothing'}")
    print("  N  cases  plan s      bytes  one ms  p99 ms  by                   scenes/s  succeeds  judged  invalid")
    wrong = 0
    for n in map(int, asked.sizes.split(",")):
        plan, seconds, size = plan_for(n)
        cases = sum(len(pool.cases) for pool in plan.document.combinations[0].pools)
        fast, (one, late) = rate(plan, asked.batch), latency_ms(plan)
        invalid = len({row["index"] for row in Judge(plan).violations(sample(plan, asked.check, 1))})
        wrong += invalid
        print(
            f"{n:3} {cases:6} {seconds:7.1f} {size:10} {one:7.3f} {late:7.3f}  "
            f"{'plan':17} {fast:11.1f} {1:9.1%} {asked.check:7} {invalid:8}",
            flush=True,
        )
        boxes, pairs = sizes_and_pairs(n, 0)
        slow, share = rejection(boxes, pairs, asked.limit)
        print(f"{n:3} {'':41}{'numpy':17} {slow:11.1f} {share:9.1%}", flush=True)
        for name, module in present.items():
            slow, share, poses = import_module(module).rejection(boxes, pairs, TRIES, asked.limit, asked.check)
            bad = refused(plan, poses)
            print(f"{n:3} {'':41}{name:17} {slow:11.1f} {share:9.1%} {len(poses):7} {bad:8}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
