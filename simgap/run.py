"""A sim-gap search from a measurement folder to its report: conventions, search, pictures, files, stored parts.

`find` is the entry point. Candidates are fitted in forked processes; every finished part is stored, so that an
interrupted search continues and a finished one answers at once.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import count
from pathlib import Path
from typing import Any, Protocol

from jobs.cache import content_key, write_atomically
from jobs.versions import code_hash, library_versions
from schemas.diagnostics import Diagnostic, InvalidInput, Severity
from schemas.sim_gap.report import GapReport
from simgap.case import Case, case_of, convention_checks_of, declared_rollout
from simgap.engine_comparison.compare import EngineRollouts, compare_engines, most_telling, rollouts_in_engine
from simgap.extension.extension import terms_of
from simgap.find_gap import find_effects
from simgap.inference.candidate_fit import Map
from simgap.problem import Candidate
from simgap.recording.read import Measurement, read
from simgap.report.html import PAGE, PICTURES, REPORT, render_page
from simgap.report.localise_error import localise_error
from simgap.report.pictures.ablation import ablation
from simgap.report.pictures.engines import engines
from simgap.report.pictures.events import outcomes
from simgap.report.pictures.left_over import left_over
from simgap.report.pictures.overlay import overlay
from simgap.report.pictures.unexplained import unexplained
from simgap.report.side_by_side import largest_improvement, side_by_side
from simgap.result_store import ResultStore
from simgap.search_result import SearchResult

Work = Callable[[Candidate], Any]
_MOST_REPLAYED = 12  # held-out trials among which the most telling one is looked for


class Tick(Protocol):
    """A callback for progress: the current step, and the finished and total items where these are known."""

    def __call__(self, words: str, done: int = 0, total: int | None = None) -> None:
        """Called whenever something begins or ends."""
        ...


def find(
    measurement: str | Path,
    out: str | Path,
    *,
    engine: str,
    jobs: int = 1,
    quick: bool = False,
    tick: Tick | None = None,
) -> GapReport:
    """Name the effect that the declared model of a measurement folder lacks; write report, page and extension to `out`.

    `engine` names the physics engine that rolls out bodies (`"sim.bullet.replay_engine:BulletReplayEngine"` is
    PyBullet). Any number of `jobs` gives the same answer; `quick` leaves out what no verdict
    rests on: the slow baseline with all effects at once, the roll-out of the declared model in the engine; `tick` is
    called as the search goes on. An answer that `out` already holds is returned at once.

    Raises InvalidInput with the first error of a folder that cannot be used.
    """
    since, outcome = time.monotonic(), read(Path(measurement))
    if outcome.value is None:
        errors = [d for d in outcome.diagnostics if d.severity is Severity.ERROR]
        raise InvalidInput((errors or list(outcome.diagnostics))[0])
    silent: Tick = lambda words, done=0, total=None: None  # noqa: E731
    return search(
        outcome.value,
        outcome.diagnostics,
        Path(out),
        engine=engine,
        jobs=jobs,
        tick=tick or silent,
        since=since,
        quick=quick,
    )


def search(
    measurement: Measurement,
    findings: Sequence[Diagnostic],
    out: Path,
    *,
    engine: str,
    jobs: int,
    tick: Tick,
    since: float,
    quick: bool = False,
) -> GapReport:
    """The report, after writing it with extension, page and pictures into `out`.

    An answer that `out` already holds is not worked out again; an interrupted run continues with what it had finished.
    """
    store = ResultStore(out, answer_key(measurement, quick))
    if store.answered():
        return GapReport.model_validate_json((out / REPORT).read_bytes())
    case = case_of(measurement, engine)
    tick("checking the simulator's conventions")
    checks = store.part("traps", lambda: convention_checks_of(case, findings))
    tick("localising the error")
    ids = (*case.trials.train, *case.trials.test)
    where = store.part("localise", lambda: localise_error(case.problem, (), ids, case.joints))
    result = find_effects(
        case.problem,
        case.trials,
        measurement=measurement.content_hash,
        horizon_s=case.problem.horizon_s,
        checks=checks,
        localisation=where,
        each=_each(jobs, tick, store),
        quick=quick,
    )
    rollouts = None if quick else _in_engine(case, tick, store)
    tick("drawing")
    pictures = _pictures(case, result, rollouts)
    extension = result.extension.model_copy(update={"target": _target(measurement)})
    name, wall_s = measurement.spec.name, round(time.monotonic() - since, 1)
    report = result.report.model_copy(
        update={
            "measurement_name": name,
            "wall_s": wall_s,
            "rollout": declared_rollout(case),
            "engine_comparison": None
            if rollouts is None
            else compare_engines(rollouts, case.problem.channels(), case.problem.channel_units()),
        }
    )
    files = {f"{PICTURES}/{name}": data for name, data in pictures.items()}
    for stale in (p for p in (out / PICTURES).glob("*.png") if p.name not in pictures):
        stale.unlink()
    for name, data in files.items():  # The page holds them.
        write_atomically(out / name, data)
    files |= {report.extension: extension.model_dump_json(indent=1).encode()}
    files |= {REPORT: report.model_dump_json(indent=1).encode(), PAGE: render_page(report, out).encode()}
    store.finish(files)
    return report


def answer_key(measurement: Measurement, quick: bool) -> str:
    """Hash of the inputs of an answer: the measurement, the options, our code and the libraries below it."""
    return content_key("gap find", measurement.content_hash, quick, library_versions(), code_hash(("simgap",)))


def _target(measurement: Measurement) -> dict[str, str]:
    """The package or URDF that the extension applies to, as the subject names it."""
    subject = measurement.spec.subject
    given = {"package": subject.package, "urdf": subject.urdf}
    return {key: path for key, path in given.items() if path is not None}


def _in_engine(case: Case, tick: Tick, store: ResultStore) -> EngineRollouts | None:
    """The declared mechanism in the user's engine; None for what the engine rolls out anyway, and for events."""
    mechanism = case.problem.declared_mechanism()
    if mechanism is None:
        return None
    tick("rolling out the declared model in the engine")
    return store.part("engine", lambda: rollouts_in_engine(case, mechanism))


def _pictures(case: Case, result: SearchResult, rollouts: EngineRollouts | None) -> dict[str, bytes]:
    """PNG files by name."""
    problem, final = case.problem, result.final_model
    events = problem.as_events()
    if events is not None:
        drawn = outcomes(events, case.trials.test, terms_of(result.extension))
        return {"overlay.png": drawn, "ladder.png": ablation(result.report.ladder)}
    judged = [t for t in case.measurement.trials if t.id in set(case.trials.test)][:_MOST_REPLAYED]
    declared = [side_by_side(problem, t, ()) for t in judged]
    added = terms_of(result.extension)
    extended = [side_by_side(problem, t, added) for t in judged] if added else None
    floor = problem.noise_floor(case.trials.test, "full_rollout")
    at, channel = largest_improvement(declared, extended or declared, floor)
    unit = problem.channel_units()[channel]
    drawn = {
        "overlay.png": overlay(declared[at], extended[at] if extended else None, channel, unit),
        "ladder.png": ablation(result.report.ladder),
    }
    if rollouts is not None and rollouts.trials:
        trial, joint = most_telling(rollouts)
        of_joint = problem.channels()[joint], problem.channel_units()[joint]
        engine, step_s = rollouts.engine.name, rollouts.engine.step_s or 0.0
        drawn["engines.png"] = engines(rollouts.trials[trial], joint, *of_joint, engine, step_s)
    mechanism = problem.declared_mechanism()
    if result.accepted and mechanism is not None:
        best = result.accepted[0]
        ids = (*case.trials.train, *case.trials.test)
        picture = unexplained(mechanism, case.measurement, final, best.effect.name, best.where, ids)
        drawn |= {"unexplained.png": picture} if picture else {}
    if result.report.verdict.status == "outside_model_class" and mechanism is not None:
        picture = left_over(mechanism, case.measurement, final, (*case.trials.train, *case.trials.test))
        drawn |= {"left_over.png": picture} if picture else {}
    return drawn


def _each(jobs: int, tick: Tick, store: ResultStore) -> Map:
    """Fits candidates one after another, or in forked processes that inherit the problem, with equal order and results.

    Each result is stored as soon as it is done, under the number of the call: equal keys make equal calls.
    """
    calls = count()

    def each(work: Work, items: Iterable[Candidate]) -> Iterator[Any]:
        call, todo = next(calls), list(items)

        def fit_at(position: int) -> Any:
            return store.part(f"{call}/{position}/{todo[position].key}", lambda: work(todo[position]))

        def report_candidate(done: int, verb: str, item: Candidate) -> None:
            tick(f"step {call + 1}: {verb} {item.effect.name} at {item.where}", done, len(todo))

        if jobs == 1 or len(todo) < 2:
            for n, item in enumerate(todo):
                report_candidate(n, "trying", item)
                yield fit_at(n)
        else:
            global _work
            _work = fit_at
            with multiprocessing.get_context("fork").Pool(jobs) as pool:
                for n, trial in enumerate(pool.imap(_inherited, range(len(todo)))):
                    report_candidate(n + 1, "tried", todo[n])
                    yield trial
        tick(f"step {call + 1}: comparing the best", len(todo), len(todo))

    return each


_work: Callable[[int], Any] | None = None  # What forked processes inherit; functions with state cannot be sent.


def _inherited(position: int) -> Any:
    assert _work is not None
    return _work(position)
