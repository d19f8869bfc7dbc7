"""Causes named one by one against CMA-ES over every contact parameter of the engine, on tosses that neither has seen.

    python -m examples.measured.cube_toss SOURCE FOLDER
    python -m benchmarks.gap.cubes FOLDER [--tosses 60] [--first 0] [--evaluations 1000] [--json]

Takes every n-th toss, 70 % to teach and 30 % to judge. CMA-ES gets PyBullet's friction, restitution, rolling and
spinning friction, contact stiffness and damping, once fitted on windows of 80 ms and once on whole tosses, by the loss
of Acosta, Yang, Posa (RA-L 2022): mean of 19.08 |dp|^2 + angle^2. Per toss the mean error over time: position as a
share of the cube's side, rotation in degrees; "ahead" is CMA-ES minus ours per toss with a 95 % interval by bootstrap
over tosses.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import cma
import numpy as np

from cli.engines import REPLAY_ENGINE
from schemas.arrays import FloatArray
from sim.dynamics.hooks import Series
from simgap.case import Case, case_of
from simgap.find_gap import find_effects
from simgap.kinds.free_body.candidates import candidates_of
from simgap.kinds.free_body.problem import FreeBodyProblem
from simgap.problem import Candidate, Model, Term, View
from simgap.recording.read import Measurement, read
from simgap.recording.train_test_split import Trials

VIEWS: tuple[View, ...] = ("short_horizon", "full_rollout")
CONTACT = ("friction", "restitution", "rolling_friction", "spinning_friction", "compliance")
BY_DECADES = ("stiffness_Npm",)
POSITION_WEIGHT = 19.08
SIGMA, SEED = 0.25, 1
Metrics = dict[str, FloatArray]


def subset(measurement: Measurement, count: int, first: int) -> Measurement:
    """Every n-th toss from the `first` on, so many in all."""
    every = max(1, len(measurement.trials) // count)
    return replace(measurement, trials=measurement.trials[first::every][:count])


def errors(problem: FreeBodyProblem, model: Model, trials: Sequence[str], view: View) -> Metrics:
    """Per toss (n,) mean distance in m and mean angle in rad over the compared rows."""
    residuals = problem.residuals(model, trials, view)
    return {
        "position": np.array([np.linalg.norm(r[:, :3], axis=1).mean() for r in residuals]),
        "rotation": np.array([np.linalg.norm(r[:, 3:6], axis=1).mean() for r in residuals]),
    }


def by_cma(problem: FreeBodyProblem, trials: Sequence[str], view: View, evaluations: int) -> Model:
    """The contact parameters with the least loss on `trials` that so many roll-outs of them find."""
    declared = problem.simulator.apply(()).body
    series = [Series(t.t_s, {"v_W": t.v_W}) for t in problem.measurement.trials if t.id in trials]
    contact = [c for c in candidates_of(declared, series) if c.effect.name in {f"contact.{n}" for n in CONTACT}]

    def loss(shares: FloatArray) -> float:
        found = problem.residuals(_model(contact, shares), trials, view)
        each = [(POSITION_WEIGHT * (r[:, :3] ** 2).sum(1) + (r[:, 3:6] ** 2).sum(1)).mean() for r in found]
        return float(np.mean(each))

    count = sum(len(c.bounds) for c in contact)
    options = {"bounds": [0.0, 1.0], "maxfevals": evaluations, "seed": SEED, "verbose": -9}
    strategy = cma.CMAEvolutionStrategy(np.full(count, 0.3), SIGMA, options)
    strategy.optimize(loss)
    return _model(contact, np.asarray(strategy.result.xbest))


def _model(contact: Sequence[Candidate], shares: FloatArray) -> Model:
    rest = iter(shares.tolist())
    return tuple(
        Term(c, {name: _value(next(rest), low, high, name) for name, (low, high) in c.bounds.items()}) for c in contact
    )


def _value(share: float, low: float, high: float, name: str) -> float:
    return low * (high / low) ** share if name in BY_DECADES else low + share * (high - low)


def ahead(theirs: FloatArray, ours: FloatArray) -> tuple[float, float, float]:
    """Mean of theirs minus ours over tosses with its 95 % interval."""
    apart = theirs - ours
    draws = np.random.default_rng(0).integers(0, len(apart), (5000, len(apart)))
    low, high = np.quantile(apart[draws].mean(axis=1), [0.025, 0.975])
    return float(apart.mean()), float(low), float(high)


def named_by_us(case: Case, trials: Trials) -> tuple[Model, str]:
    """The extended model, and what was said."""
    outcome = find_effects(case.problem, trials, measurement="", horizon_s=0.0, quick=True)
    verdict = outcome.report.verdict
    return outcome.final_model, f"{verdict.status}: {verdict.statement}"


def main() -> None:
    """Both on the same split, printed as a table."""
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("folder", type=Path)
    ask.add_argument("--tosses", type=int, default=60)
    ask.add_argument("--first", type=int, default=0)
    ask.add_argument("--evaluations", type=int, default=1000)
    ask.add_argument("--json", action="store_true", help="numbers instead of a table")
    asked = ask.parse_args()
    measurement = read(asked.folder).value
    if measurement is None:
        raise SystemExit(f"{asked.folder}: not a measurement; `mana gap simulate` says why")
    case = case_of(subset(measurement, asked.tosses, asked.first), REPLAY_ENGINE)
    problem = case.problem
    assert isinstance(problem, FreeBodyProblem), "tosses are free bodies"
    unit = {"position": 1.0 / problem.simulator.size_m, "rotation": 180.0 / np.pi}

    def timed(work: Callable[[], Model]) -> tuple[Model, float]:
        since = time.process_time()
        return work(), time.process_time() - since

    since = time.process_time()
    ours, statement = named_by_us(case, case.trials)
    models: dict[str, tuple[Model, float]] = {"declared": ((), 0.0), "ours": (ours, time.process_time() - since)}
    for view in VIEWS:
        models[f"CMA-ES on {view}"] = timed(
            lambda view=view: by_cma(problem, case.trials.train, view, asked.evaluations)
        )
    rows: list[dict[str, object]] = []
    for view in VIEWS:
        mine = errors(problem, ours, case.trials.test, view)
        for name, (model, cpu_s) in models.items():
            these = errors(problem, model, case.trials.test, view)
            row: dict[str, object] = {"judged_on": view, "model": name, "cpu_s": round(cpu_s, 1)}
            for what, scale in unit.items():
                row[what] = float(these[what].mean() * scale)
                row[f"{what}_ahead"] = [v * scale for v in ahead(these[what], mine[what])]
            rows.append(row)
    values = {name: {t.candidate.key: t.values for t in model} for name, (model, _) in models.items()}
    if asked.json:
        print(json.dumps({"said": statement, "rows": rows, "models": values}, indent=1))
        return
    print(f"{len(case.trials.train)} tosses teach, {len(case.trials.test)} judge. {statement}\n")
    print(
        "| judged on | model | position / side | ahead by | rotation, deg | ahead by | CPU s |\n"
        "|---|---|---|---|---|---|---|"
    )
    for r in rows:
        cells = [
            f"{r['position']:.4f}",
            _interval(r["position_ahead"]),
            f"{r['rotation']:.2f}",
            _interval(r["rotation_ahead"]),
        ]
        print(f"| {r['judged_on']} | {r['model']} | {' | '.join(cells)} | {r['cpu_s']} |")
    print("\n".join(f"\n{name}: {found}" for name, found in values.items()))


def _interval(value: object) -> str:
    middle, low, high = value if isinstance(value, list) else (0.0, 0.0, 0.0)
    return f"{middle:.4f} ({low:.4f} to {high:.4f})"


if __name__ == "__main__":
    main()
