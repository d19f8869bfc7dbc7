"""Measures whether verdicts are true: proofs against exhaustive grids, scenes against the independent judge.

    python -m benchmarks.scenes.truth [--programs 300] [--scenes 20000] [--start 0]

Programs are random and small; `tests/support/scene/truth.py` tries all poses of a grid and answers yes, no or unclear.
Scenes are those that the solver finds for random mixed problems; `scene_check` shares no code with it. Times are
CPU times.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter

import numpy as np

from scenec.check.judge_scene import violations
from scenec.ir.problem import Infeasible, Solved
from scenec.proofs import prove
from scenec.solve import solve
from tests.support.scene.random_problems import mixed_problem, random_problem
from tests.support.scene.truth import truth

BUDGET = 2000


def proofs_against_truth(start: int, count: int) -> None:
    """Print how many proofs are false, and how many programs without a scene are proved so."""
    table: Counter[tuple[str, str]] = Counter()
    kinds: Counter[str] = Counter()
    seconds = []
    for seed in range(start, start + count):
        case = random_problem(seed)
        since = time.process_time()
        proof = prove(case)
        seconds.append(time.process_time() - since)
        answer = truth(case)
        table[answer, "proved" if proof else "no proof"] += 1
        kinds.update([proof.kind] if proof else [])
        if answer == "yes" and proof is not None:
            print(f"  FALSE PROOF: seed {seed}: {proof.text}")
        if answer == "no" and proof is None:
            print(f"  not proved: seed {seed}")
    none = table["no", "proved"] + table["no", "no proof"]
    print(f"{count} programs: {table['yes', 'proved'] + table['yes', 'no proof']} have a scene, {none} have none,")
    print(f"  {count - none - table['yes', 'proved'] - table['yes', 'no proof']} unclear on the finest grid")
    print(f"false proofs: {table['yes', 'proved']}")
    print(f"proved of those without a scene: {table['no', 'proved']} of {none} ({table['no', 'proved'] / none:.1%})")
    print("by argument:", ", ".join(f"{kind} {many}" for kind, many in kinds.most_common()))
    print(
        f"CPU time of a proof or none: median {np.median(seconds):.4f} s, 99 of 100 {np.quantile(seconds, 0.99):.2f} s"
    )


def scenes_against_judge(start: int, count: int) -> None:
    """Print the verdicts of compiled problems and how many scenes the judge refuses."""
    verdicts: Counter[str] = Counter()
    invalid, solving, judging = 0, 0.0, 0.0
    for seed in range(start, start + count):
        case = mixed_problem(seed)
        since = time.process_time()
        result = solve(case, seed, BUDGET)
        solving += time.process_time() - since
        verdicts[type(result).__name__ if not isinstance(result, Infeasible) else "Infeasible"] += 1
        if isinstance(result, Solved):
            since = time.process_time()
            wrong = violations(case, result.placements)
            judging += time.process_time() - since
            if wrong:
                invalid += 1
                print(f"  INVALID: seed {seed}: {wrong[0]}")
        if (seed - start + 1) % 1000 == 0:
            print(f"  {seed - start + 1}: {dict(verdicts)}, {invalid} invalid", flush=True)
    print(f"{count} problems: {dict(verdicts)}; scenes refused by the judge: {invalid}")
    print(f"CPU time of a problem: {solving / count * 1e3:.1f} ms; of a judgement: {judging / count * 1e3:.1f} ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=int, default=300)
    parser.add_argument("--scenes", type=int, default=20_000)
    parser.add_argument("--start", type=int, default=0)
    args = parser.parse_args()
    if args.programs:
        proofs_against_truth(args.start, args.programs)
    if args.scenes:
        scenes_against_judge(args.start, args.scenes)


if __name__ == "__main__":
    main()
