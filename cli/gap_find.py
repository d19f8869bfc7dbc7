"""The work of `mana gap find`: traps, search, pictures, files."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from cli.gap_problem import Case, case_of, traps_of
from jobs.cache import write_atomically
from schemas.diagnostics import Diagnostic
from schemas.gap import GapReport
from simgap.extension import terms_of
from simgap.find import Found, find
from simgap.localise import localise
from simgap.measurement import Measurement
from simgap.mechanism.problem import MechanismProblem
from simgap.pictures.ladder import ladder
from simgap.pictures.overlay import overlay
from simgap.pictures.unexplained import unexplained
from simgap.problem import Candidate
from simgap.replays import most_telling, replay
from simgap.report_page import PAGE, PICTURES, REPORT, render_page
from simgap.search import Trial

Tick = Callable[[str], None]
Work = Callable[[Candidate], Trial]
_MOST_REPLAYED = 12  # held-out trials among which the most telling one is looked for


def search(
    measurement: Measurement, findings: Sequence[Diagnostic], out: Path, *, jobs: int, tick: Tick, since: float
) -> GapReport:
    """The report, after writing it with extension, page and pictures into `out`."""
    case = case_of(measurement)
    tick("checking the simulator's conventions")
    traps = traps_of(case, findings)
    tick("localising the error")
    where = localise(case.problem, (), (*case.trials.train, *case.trials.test), case.joints)
    found = find(
        case.problem,
        case.trials,
        measurement=measurement.content_hash,
        horizon_s=case.problem.horizon_s,
        traps=traps,
        localisation=where,
        each=_each(jobs, tick),
    )
    tick("drawing")
    pictures = _pictures(case, found)
    report = found.report.model_copy(update={"wall_s": round(time.monotonic() - since, 1)})
    for name, data in pictures.items():
        write_atomically(out / PICTURES / name, data)
    for stale in (p for p in (out / PICTURES).glob("*.png") if p.name not in pictures):
        stale.unlink()
    write_atomically(out / report.extension, found.extension.model_dump_json(indent=1).encode())
    write_atomically(out / REPORT, report.model_dump_json(indent=1).encode())
    write_atomically(out / PAGE, render_page(report, out).encode())
    return report


def _pictures(case: Case, found: Found) -> dict[str, bytes]:
    """PNG files by name."""
    problem, final = case.problem, found.selection.final.model
    judged = [t for t in case.measurement.trials if t.id in set(case.trials.test)][:_MOST_REPLAYED]
    declared = [replay(problem, t, ()) for t in judged]
    added = terms_of(found.extension)
    extended = [replay(problem, t, added) for t in judged] if added else None
    floor = problem.noise_floor(case.trials.test, "full_rollout")
    at, channel = most_telling(declared, extended or declared, floor)
    sliding = (
        case.joints and problem.declared.tree[channel].prismatic if isinstance(problem, MechanismProblem) else True
    )
    unit = "m" if sliding else "rad"
    drawn = {
        "overlay.png": overlay(declared[at], extended[at] if extended else None, channel, unit),
        "ladder.png": ladder(found.report.ladder),
    }
    if found.selection.accepted and isinstance(problem, MechanismProblem):
        best = found.selection.accepted[0].candidate
        ids = (*case.trials.train, *case.trials.test)
        picture = unexplained(problem, case.measurement, final, best.effect.name, best.where, ids)
        drawn |= {"unexplained.png": picture} if picture else {}
    return drawn


def _each(jobs: int, tick: Tick) -> Callable[[Work, Iterable[Candidate]], Iterator[Trial]]:
    """Candidates one after another, or in forked processes that inherit the problem; order and results are the same."""

    def each(work: Work, items: Iterable[Candidate]) -> Iterator[Trial]:
        todo = list(items)
        if jobs == 1 or len(todo) < 2:
            for n, item in enumerate(todo):
                tick(f"trying {item.effect.name} at {item.where} ({n + 1} of {len(todo)})")
                yield work(item)
            return
        global _work
        _work = work
        with multiprocessing.get_context("fork").Pool(jobs) as pool:
            for n, done in enumerate(pool.imap(_inherited, todo)):
                tick(f"tried {done.candidate.effect.name} at {done.candidate.where} ({n + 1} of {len(todo)})")
                yield done

    return each


_work: Work | None = None  # What forked processes inherit; functions with state cannot be sent.


def _inherited(item: Candidate) -> Trial:
    assert _work is not None
    return _work(item)
