"""Measures how fast scenes are solved: the tabletop workload, edits, and growth with the number of objects.

    python -m benchmarks.scenes.solve_speed [--sizes 5,10,30,60,80] [--seeds 3] [--limit 5]

CPU seconds of a warm process, medians over seeds, the baselines in the same run under a limit of CPU seconds for each
seed; `solved` counts seeds. Every scene is judged by scene_check. Exit code 1 when one is invalid.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
from shapely import box

from benchmarks.scenes.baselines import circles, oriented_boxes, shelves
from benchmarks.scenes.workload import box_body, program_text, sizes_and_pairs, workload
from scenec.check.judge_scene import violations
from scenec.compile import Compiled, compile_program
from scenec.ir.problem import Infeasible, Placement, Problem, Solved, Thing
from scenec.session import Session
from scenec.solve import ComponentCache, solve
from scenec.solve.model import model_of
from scenec.solve.search import SearchBudget, search
from schemas.scene.compiled import CompileReport
from schemas.scene.geometry import BACKGROUND, Domain, ScenePlace

BASELINES = {"circles (robosuite rule)": circles, "oriented boxes": oriented_boxes, "python shelf and swaps": shelves}


def timed(work: Callable[[], object]) -> tuple[float, float, object]:
    """(CPU seconds, wall seconds, what came out)."""
    cpu, wall = time.process_time(), time.perf_counter()
    value = work()
    return time.process_time() - cpu, time.perf_counter() - wall, value


def invalid(problem: Problem, result: object) -> int:
    return len(violations(problem, result.placements)) if isinstance(result, Solved) else 0


def row(name: str, n: int, solved: int, seeds: int, cpu: list[float], wall: list[float], wrong: int) -> int:
    figures = f"{1e3 * median(cpu):9.1f} {1e3 * max(cpu):9.1f} {1e3 * median(wall):9.1f}" if cpu else " " * 29
    print(f"{name:28} {n:4} {solved}/{seeds} {figures}  {wrong}", flush=True)
    return wrong


def first_scene(sizes: list[int], seeds: int, limit_s: float) -> int:
    print(f"{'first valid scene':28} {'n':>4} solved {'cpu ms':>7} {'worst':>9} {'wall ms':>9}  violations")
    wrong = 0
    for n in sizes:
        solve(workload(n, seeds), 0)  # warms up on another seed
        runs = [(problem, timed(lambda p=problem: solve(p, 0))) for problem in (workload(n, s) for s in range(seeds))]
        found = [(cpu, wall) for _, (cpu, wall, result) in runs if isinstance(result, Solved)]
        bad = sum(invalid(problem, result) for problem, (_, _, result) in runs)
        wrong += row("scenec", n, len(found), seeds, [c for c, _ in found], [w for _, w in found], bad)
        if n <= 30:
            wrong += exact_search(n, seeds)
        for name, method in BASELINES.items():
            times: list[tuple[float, float]] = []
            bad = 0
            for seed in range(seeds):
                given, rng = sizes_and_pairs(n, seed), np.random.default_rng([1, seed])
                cpu, wall, poses = timed(lambda m=method, g=given, r=rng: m(*g, r, limit_s))
                if isinstance(poses, np.ndarray):
                    times.append((cpu, wall))
                    placed = {f"box{i}": Placement(x, y, yaw, 0) for i, (x, y, yaw) in enumerate(poses.tolist())}
                    bad += invalid(workload(n, seed), Solved(placed))
            row(name, n, len(times), seeds, [c for c, _ in times], [w for _, w in times], bad)
    return wrong


def exact_search(n: int, seeds: int) -> int:
    """The fallback alone: exact regions at free yaw, no family before it."""
    times, wrong = [], 0
    for seed in range(seeds):
        problem = workload(n, seed)
        model = model_of(problem)
        cpu, wall, found = timed(lambda m=model: search(m, list(m.things), {}, 0, SearchBudget(5000)))
        if isinstance(found, dict):
            times.append((cpu, wall))
            wrong += invalid(problem, Solved({name: placed.placement for name, placed in found.items()}))
    return row("scenec, exact regions alone", n, len(times), seeds, [c for c, _ in times], [w for _, w in times], wrong)


def three_cycle(seeds: int) -> None:
    runs = [timed(lambda s=seed: solve(workload(10, s, cycle=True), 0)) for seed in range(seeds)]
    named = [sorted(r.proof.paths) for _, _, r in runs if isinstance(r, Infeasible)]
    right = sum(paths == [("relations", 0), ("relations", 1), ("relations", 2)] for paths in named)
    cpu_ms = 1e3 * median(cpu for cpu, _, _ in runs)
    print(f"\nthree left_of in a circle, n = 10: named exactly {right}/{seeds}, {cpu_ms:.1f} ms cpu")


def edit(n: int, edits: int) -> int:
    """One object gets another size: the scene repaired from the last one, against solving from nothing."""
    problem, cache = workload(n, 0), ComponentCache()
    before = solve(problem, 0, cache=cache)
    assert isinstance(before, Solved)
    full, repaired, moved, wrong = [], [], [], 0
    for k in range(edits):
        i = (7 * k) % n
        other = replace(problem.things[i], body=box_body("edited", 0.06 + 0.002 * k, 0.05))
        changed = replace(problem, things=(*problem.things[:i], other, *problem.things[i + 1 :]))
        full.append(timed(lambda p=changed: solve(p, 0))[0])
        cpu, _, after = timed(lambda p=changed: solve(p, 0, previous=before.placements, cache=cache))
        repaired.append(cpu)
        assert isinstance(after, Solved)
        moved.append(sum(after.placements[name] != before.placements[name] for name in before.placements))
        wrong += invalid(changed, after)
    warm, cold = 1e3 * median(repaired), 1e3 * median(full)
    print(f"\none object changed, n = {n}: {warm:.1f} ms cpu from the last scene, {cold:.1f} ms from nothing;", end=" ")
    print(f"objects moved: median {median(moved):.0f}, most {max(moved)}; {wrong} violations")
    return wrong


def edit_text(n: int, edits: int) -> None:
    """The same through the text: a warm session, each edit one object of the last text, beside compiling all of it."""
    print(f"\none object changed in the text, n = {n}: ms cpu, median and least of {edits} edits")
    for what in ("other numbers", "a key more", "a line more above"):
        _edits(what, n, edits)


def _edits(what: str, n: int, edits: int) -> None:
    sizes, pairs = sizes_and_pairs(n, 0)
    cold, warm, phases = [], [], Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        file, session = Path(folder) / "program.yaml", Session()
        file.write_text(program_text(sizes, pairs))
        session.compile(file)
        for k in range(edits):
            file.write_text(_edited(what, k, sizes, pairs))
            cold.append(timed(lambda: compile_program(file))[0])
            cpu, _, compiled = timed(lambda: session.compile(file))
            warm.append(cpu)
            assert isinstance(compiled, Compiled)
            assert compiled.scenes
            phases.update({name: 1e3 * seconds / edits for name, seconds in compiled.report.phases.items()})
    print(f"  {what:20} anew {1e3 * median(cold):7.1f} {1e3 * min(cold):7.1f}", end="")
    print(f"   in a session {1e3 * median(warm):6.1f} {1e3 * min(warm):6.1f}", end="")
    print(f"   {median(warm) / median(cold):.1%} and {min(warm) / min(cold):.1%} of it")
    print("    wall of its phases, mean:", ", ".join(f"{name} {ms:.1f}" for name, ms in phases.items()))


def _edited(what: str, k: int, sizes: np.ndarray, pairs: list[tuple[int, int]]) -> str:
    # The text after edit k: one more object than before it has another size, or a scale.
    edited = [(7 * j) % len(sizes) for j in range(k + 1)]
    if what == "other numbers":
        sizes[edited[-1]] = 0.06 + 0.002 * k, 0.05
    text = program_text(sizes, pairs)
    for number in edited if what == "a key more" else ():
        text = text.replace(f"id: box{number},", f"id: box{number}, scale: 0.9,")
    return "# a line\n" * (k + 1) + text if what == "a line more above" else text


def many_supports(n: int) -> Problem:
    """n boxes in fives, each five on a table of its own beside the others."""
    rng = np.random.default_rng([3, n])
    tables = [
        ScenePlace(f"table{k}", box(-0.3, -0.3, 0.3, 0.3), np.array([0.8 * k, 0.0, 0.0])) for k in range(-(-n // 5))
    ]
    bodies = [box_body(f"box{i}", *rng.uniform(0.04, 0.14, 2)) for i in range(n)]
    things = tuple(
        Thing(f"box{i}", body, BACKGROUND, tables[i // 5], Domain(), ("layout", "nodes", f"box{i}"))
        for i, body in enumerate(bodies)
    )
    return replace(workload(1, 0), things=things, relations=())


def growth() -> int:
    print(f"\n{'objects over several supports':30} {'cpu ms':>8} {'ms an object':>13}  violations")
    wrong = 0
    for n in (5, 10, 20, 50, 100, 200, 500):
        problem = many_supports(n)
        solve(problem, 0)
        runs = [timed(lambda p=problem: solve(p, 0)) for _ in range(3)]
        cpu = median(c for c, _, _ in runs)
        bad = invalid(problem, runs[0][2])
        wrong += bad
        print(f"{n:30} {1e3 * cpu:8.1f} {1e3 * cpu / n:13.3f}  {bad}", flush=True)
    return wrong


def racks(k: int) -> str:
    """k racks in places of their own, each with two boxes that have four assignments to its slots."""
    lines = [f"background: {{asset: {{type: box, size_m: [{0.5 * k}, 0.5, 0.04]}}}}"]
    lines += ["anchors: {top: {object: background, surface: auto}}", "objects:"]
    lines += [f"  - {{id: {a}{i}, asset: {{type: box, size_m: [0.06, 0.05, 0.05]}}}}" for i in range(k) for a in "ab"]
    lines += ["layout:", "  nodes: {" + ", ".join(f"{a}{i}: {{object: {a}{i}}}" for i in range(k) for a in "ab") + "}"]
    lines += ["  groups:"]
    for i in range(k):
        slots = ", ".join(f"{{id: s{n}, x: {0.5 * i - 0.25 * k + 0.1 * (n + 1):.3f}, y: 0}}" for n in range(4))
        lines.append(f"    rack{i}: {{type: slot, members: [a{i}, b{i}], surface: top, slots: [{slots}]}}")
    lines += ["variants:", "  slots:"]
    for i in range(k):
        lines += [f"    - {{id: r{i}v{n}, group: rack{i}, assign: {{a{i}: s{n}, b{i}: s{n + 1}}}}}" for n in range(3)]
    return "\n".join([*lines, ""])


def variants() -> None:
    print(f"\n{'components of 4 combinations':30} {'of all':>10} {'verdicts':>9} {'cpu ms':>8} {'ms a component':>15}")
    with tempfile.TemporaryDirectory() as folder:
        for k in (1, 2, 4, 8, 16, 32):
            file = Path(folder) / "racks.yaml"
            file.write_text(racks(k))
            runs = [timed(lambda at=file: compile_program(at).report) for _ in range(3)]
            report = runs[0][2]
            assert isinstance(report, CompileReport), report
            assert report.verdict == "compiled", report
            cpu, verdicts = median(c for c, _, _ in runs), sum(len(c.combinations) for c in report.components)
            print(f"{k:30} {report.combinations:10.2g} {verdicts:9} {1e3 * cpu:8.1f} {1e3 * cpu / k:15.2f}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", default="5,10,30,60,80")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--limit", type=float, default=5.0, help="CPU seconds for each baseline and seed")
    given = parser.parse_args()
    wrong = first_scene([int(n) for n in given.sizes.split(",")], given.seeds, given.limit)
    three_cycle(given.seeds)
    wrong += edit(30, 15)
    edit_text(30, 30)
    wrong += growth()
    variants()
    raise SystemExit(wrong > 0)


if __name__ == "__main__":
    main()
