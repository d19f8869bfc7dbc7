"""`python -m tests.suites.gap.run --n N`: how often hidden effects are named, and how often names are invented."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

from schemas.sim_gap.report import GapReport, Verdict
from simgap.find_gap import find_effects
from simgap.inference.verdict_text import NAMED
from simgap.recording.train_test_split import split_trials
from tests.suites.gap.case import Case
from tests.suites.gap.free_body_cases import free_body_case
from tests.suites.gap.mechanism_cases import mechanism_case
from tests.suites.gap.table import table

KINDS: dict[str, Callable[[int], Case]] = {"mechanism": mechanism_case, "free_body": free_body_case}
WHOLE = {"mechanism": 450, "free_body": 51}

Record = dict[str, object]


def run_case(case: Case) -> Record:
    """One case from readings to verdict, judged against its truth."""
    began = time.process_time()
    problem = case.problem()
    trials = split_trials(case.spec, problem.trial_ids)
    report = find_effects(problem, trials, measurement=case.name, horizon_s=0.0, quick=True).report
    spent = time.process_time() - began
    best = max(report.hypotheses, key=lambda h: h.delta_bic, default=None)
    first = next(iter(report.verdict.effects), None)
    return {
        "name": case.name,
        "family": case.family,
        "size": case.size,
        "truth": list(case.truth),
        "outcome": outcome(case, report.verdict),
        "status": report.verdict.status,
        "said": said(report.verdict),
        "covered": covered(case, report),
        "ideal": case.ideal,
        "chance": case.chance,
        "reduction": 0.0 if report.gain is None else report.gain.reduction,
        "first": "" if first is None else f"{first.name}@{first.where.joint}",
        "confidence": 0.0 if first is None else first.confidence,
        "candidates": len({(h.name, h.where) for h in report.hypotheses}),
        "best_by_bic": "" if best is None or best.delta_bic <= 0.0 else best.name,
        "cpu_s": round(spent, 2),
    }


def outcome(case: Case, verdict: Verdict) -> str:
    """What happened, in one word.

    Without truth: `silent`, `doubted` (a group), `invented`. With: `named`, `part` (one of two), `group`, `missed`,
    `elsewhere` (a group without the truth), `wrong` (a sure name that is not hidden). With doubles: `pair` (the truth
    among its doubles only), `wide` (and others), `overconfident` (named, though a double fits as well).
    """
    certain = {f"{e.name}@{e.where.joint}" for e in verdict.effects if e.confidence >= NAMED}
    grouped = {name for g in verdict.ambiguous_groups for name in g.effects}
    truth = {t if "@" in t else f"{t}@None" for t in case.truth}
    names = {t.partition("@")[0] for t in truth}
    if not truth:
        return "invented" if certain else "doubted" if grouped else "silent"
    if certain - truth:
        return "wrong"
    if case.doubles:
        if certain:
            return "overconfident"
        if names <= grouped and len(grouped & case.doubles) > 1:
            return "pair" if grouped <= case.doubles else "wide"
        return "group" if names & grouped else "elsewhere" if grouped else "missed"
    if certain:
        return "named" if certain == truth else "part"
    return "group" if names & grouped else "elsewhere" if grouped else "missed"


def covered(case: Case, report: GapReport) -> list[bool]:
    """For each checked parameter of an effect that was named: whether its interval holds the true value."""
    inside = []
    for effect in report.verdict.effects:
        for (name, parameter), value in case.checked.items():
            if effect.name == name and effect.confidence >= NAMED:
                low, high = effect.parameters[parameter].ci95
                inside.append(low <= value <= high)
    return inside


def said(verdict: Verdict) -> str:
    """Names with their first value and confidence, then the groups."""
    words = [
        f"{e.name}@{e.where.joint}={next(iter(e.parameters.values())).value:.3g}({e.confidence:.2f})"
        for e in verdict.effects
    ]
    return ", ".join(words) + "".join(f" [{' ? '.join(g.effects)}]" for g in verdict.ambiguous_groups)


def main() -> None:
    """Prints a line per case and the table; cases whose record lies in `--resume` are not run again."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--n", type=int, help="cases of each kind; all when left out")
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--every", type=int, default=1, help="only every so many numbers")
    parser.add_argument("--kind", choices=tuple(KINDS), help="only this kind of measurement")
    parser.add_argument("--family", help="only this family: control, single, pair, two, outside")
    parser.add_argument("--resume", type=Path, help="folder of one record per case, read and filled")
    asked = parser.parse_args()
    records = []
    for kind, case_of in KINDS.items():
        if asked.kind not in (None, kind):
            continue
        count = WHOLE[kind] if asked.n is None else asked.n
        for number in range(asked.start, asked.start + count * asked.every, asked.every):
            record = _record(asked.resume, kind, number, case_of, asked.family)
            if record is not None:
                records.append(record)
                line = f"{record['name']:66} {record['outcome']:9} {record['cpu_s']:5} s  {record['said']}"
                print(f"{line}  {record['truth']}", flush=True)
    print(table(records))


def _record(
    folder: Path | None, kind: str, number: int, case_of: Callable[[int], Case], family: str | None
) -> Record | None:
    """The record of a case, from the folder if it is there; None if it is of another family."""
    file = None if folder is None else folder / f"{kind}_{number:03d}.json"
    if file is not None and file.exists():
        record: Record = json.loads(file.read_text())
        return record if family in (None, record["family"]) else None
    case = case_of(number)
    if family not in (None, case.family):
        return None
    record = run_case(case)
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(record, indent=1) + "\n")
    return record


if __name__ == "__main__":
    main()
