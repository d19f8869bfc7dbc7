"""`python -m tests.gap_suite.run --n N`: how often hidden effects are named, and how often names are invented."""

from __future__ import annotations

import argparse
import time
from collections import Counter
from dataclasses import dataclass

from schemas.gap import Verdict
from simgap.find import find
from simgap.mechanism.problem import MechanismProblem
from simgap.splits import split_trials
from simgap.verdict import NAMED
from tests.gap_suite.mechanism_cases import Case, mechanism_case


@dataclass(frozen=True)
class Result:
    """What the tool said about one case.

    `named`, `extra` (and a wrong name), `group`, `wrong`, `missed`, `elsewhere`;
    for controls `silent`, `doubted` (a group), `invented`.
    """

    case: Case
    outcome: str
    covered: bool | None
    cpu_s: float
    said: str


def run_case(number: int) -> Result:
    """One case from truth to verdict."""
    case = mechanism_case(number)
    began = time.process_time()
    problem = MechanismProblem(case.measurement)
    trials = split_trials(case.measurement.spec, problem.trial_ids)
    verdict = find(problem, trials, measurement=case.name, horizon_s=problem.horizon_s).report.verdict
    spent = time.process_time() - began
    return Result(case, _outcome(case, verdict), _covered(case, verdict), spent, _said(verdict))


def _outcome(case: Case, verdict: Verdict) -> str:
    certain = [e.name for e in verdict.effects if e.confidence >= NAMED]
    if not case.truth:
        return "invented" if certain else ("doubted" if verdict.ambiguous_groups else "silent")
    if certain:
        right = [n in case.truth for n in certain]
        return "named" if all(right) else "extra" if any(right) else "wrong"
    grouped = {n for g in verdict.ambiguous_groups for n in g.effects}
    if grouped & case.truth:
        return "group"
    return "elsewhere" if grouped else "missed"


def _covered(case: Case, verdict: Verdict) -> bool | None:
    """Whether the interval of the checked parameter holds the truth; None where it is not named."""
    for effect in verdict.effects:
        if case.parameter and effect.name in case.truth and effect.confidence >= NAMED:
            found = effect.parameters.get(case.parameter[0])
            return None if found is None else found.ci95[0] <= case.parameter[1] <= found.ci95[1]
    return None


def _said(verdict: Verdict) -> str:
    words = [f"{e.name}={next(iter(e.parameters.values())).value:.3g}({e.confidence:.2f})" for e in verdict.effects]
    return ", ".join(words) + "".join(f" [{' ? '.join(g.effects)}]" for g in verdict.ambiguous_groups)


def main() -> None:
    """Prints a line per case and the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--n", type=int, default=30)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--only", choices=("effects", "controls"))
    arguments = parser.parse_args()
    numbers = [
        k for k in range(arguments.start, arguments.start + 3 * arguments.n) if arguments.only in (None, _kind(k))
    ][: arguments.n]
    results = []
    for number in numbers:
        r = run_case(number)
        results.append(r)
        print(f"{r.case.name:34} {r.outcome:9} {r.cpu_s:5.1f} s  {r.covered}  {r.said}", flush=True)
    print(table(results))


def _kind(number: int) -> str:
    return "controls" if number % 3 == 2 else "effects"


def table(results: list[Result]) -> str:
    """Counts of outcomes by size, coverage and CPU time."""
    lines = []
    for size in ("large", "middle", "small", "control"):
        some = [r for r in results if r.case.size == size]
        counts = Counter(r.outcome for r in some)
        lines.append(f"{size:8} n={len(some):3}  " + "  ".join(f"{k} {v}" for k, v in sorted(counts.items())))
    covered = [r.covered for r in results if r.covered is not None]
    spent = sorted(r.cpu_s for r in results)
    invented = sum(r.outcome in ("invented", "wrong", "extra") for r in results)
    lines.append(f"cases with a false name {invented}/{len(results)}")
    lines.append(f"coverage {sum(covered)}/{len(covered)}")
    lines.append(f"CPU s per case: median {spent[len(spent) // 2]:.1f}, most {spent[-1]:.1f}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
