"""The work of `mana gap simulate`: readings and simulations side by side, as files."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from cli.engines import REPLAY_ENGINE
from jobs.cache import write_atomically
from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput, finding
from sim.dynamics.mechanism import rollout
from simgap.case import Case, case_of, cut_windows, replay_engine
from simgap.extension.extension import read_extension, terms_of
from simgap.kinds.mechanism.apply_model import apply_terms
from simgap.problem import EventProblem, Model, View
from simgap.recording.read import Measurement
from simgap.report.pictures.events import outcomes
from simgap.report.pictures.overlay import overlay
from simgap.report.side_by_side import SideBySide, joint_windows, largest_improvement, side_by_side

_VIEWS: tuple[View, ...] = ("short_horizon", "full_rollout")
_ENGINE_S = 3.0  # of each trial that is replayed in the engine too


def simulate(measurement: Measurement, extension: Path | None, out: Path) -> dict[str, Any]:
    """The summary that is also written as `errors.json`; trajectories as CSV, pictures as PNG.

    Raises InvalidInput for an extension that this model cannot take.
    """
    case = case_of(measurement, REPLAY_ENGINE)
    models: dict[str, Model] = {"declared": ()}
    if extension is not None:
        models["extended"] = terms_of(read_extension(extension))
        _refuse_strange_places(case, models["extended"])
    events = case.problem.as_events()
    if events is not None:
        return _events(case, events, models, out)
    runs = {name: [side_by_side(case.problem, t, model) for t in measurement.trials] for name, model in models.items()}
    for k, trial in enumerate(measurement.trials):
        write_atomically(out / "trajectories" / f"{_file(trial.id)}.csv", _csv([(n, r[k]) for n, r in runs.items()]))
    ids = case.problem.trial_ids
    floor = case.problem.noise_floor(ids, "full_rollout")
    at, channel = largest_improvement(runs["declared"], runs.get("extended", runs["declared"]), floor)
    extended = runs["extended"][at] if "extended" in runs else None
    picture = overlay(runs["declared"][at], extended, channel, case.problem.channel_units()[channel])
    write_atomically(out / "pictures" / "overlay.png", picture)
    summary = {"schema_version": 1, "errors": _errors(case, models), "notes": _engine_notes(case, models)}
    write_atomically(out / "errors.json", json.dumps(summary, indent=1).encode())
    return summary


def _events(case: Case, problem: EventProblem, models: dict[str, Model], out: Path) -> dict[str, Any]:
    """The same summary for measurements without time series: one table, a row per event."""
    ids, names = problem.trial_ids, problem.channels()
    truth = np.concatenate(problem.readings(ids))
    columns = {f"{n}_measured": truth[:, c] for c, n in enumerate(names)}
    for name, model in models.items():
        said = truth + np.concatenate(problem.residuals(model, ids, "full_rollout"))
        columns |= {f"{n}_{name}": said[:, c] for c, n in enumerate(names)}
    rows = zip(*columns.values(), strict=True)
    table = "\n".join([",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]) + "\n"
    write_atomically(out / "trajectories" / "events.csv", table.encode())
    write_atomically(out / "pictures" / "overlay.png", outcomes(problem, ids, models.get("extended", ())))
    summary = {"schema_version": 1, "errors": _errors(case, models), "notes": []}
    write_atomically(out / "errors.json", json.dumps(summary, indent=1).encode())
    return summary


def _refuse_strange_places(case: Case, model: Model) -> None:
    """An effect must sit where this model has something, and act on things of this kind."""
    for term in model:
        name, where = term.candidate.effect.name, term.candidate.where
        if where.joint is not None and where.joint not in case.joints:
            text = f"{name} sits at joint '{where.joint}'; there are {', '.join(case.joints) or 'none'}"
            raise InvalidInput(finding("gap/unknown-place", text))
        if case.measurement.spec.kind not in term.candidate.effect.kinds:
            text = f"{name} does not act on measurements of kind {case.measurement.spec.kind}"
            raise InvalidInput(finding("gap/unknown-place", text))


def _errors(case: Case, models: dict[str, Model]) -> list[dict[str, Any]]:
    """Root mean square errors over all trials."""
    rows = []
    for view in _VIEWS:
        for name, model in models.items():
            errors = np.concatenate(case.problem.residuals(model, case.problem.trial_ids, view))
            for channel, value in zip(case.problem.channels(), np.sqrt(np.nanmean(errors**2, axis=0)), strict=True):
                rows.append({"view": view, "channel": channel, "model": name, "rmse": float(value)})
    return rows


def _engine_notes(case: Case, models: dict[str, Model]) -> list[str]:
    """For mechanisms: how far PyBullet is from the roll-outs here, with the same numbers and inputs."""
    mechanism = case.problem.declared_mechanism()
    if mechanism is None:
        return []
    engine = replay_engine(REPLAY_ENGINE)
    notes = []
    for name, model in models.items():
        applied = apply_terms(mechanism, model)
        windows = cut_windows(joint_windows(case.measurement.trials[0], applied), _ENGINE_S)
        try:
            theirs, _ = engine.mechanism_rollout(applied.mechanism, windows, applied.laws)
        except ValueError as refused:
            notes.append(f"{name} model: not replayed in PyBullet: {refused}")
            continue
        ours, _ = rollout(applied.mechanism, windows, applied.laws)
        apart = float(np.abs(theirs - ours).max())
        span = float(np.ptp(ours)) or 1.0
        length = float(windows.t_s[0, -1] - windows.t_s[0, 0])
        notes.append(
            f"{name} model: PyBullet is within {apart:.2g} ({apart / span:.2%} of the range) over {length:.3g} s"
        )
    return notes


def _csv(runs: list[tuple[str, SideBySide]]) -> bytes:
    """Stamps, readings and each simulation."""
    first = runs[0][1]
    names = ["t", *(f"{c}_measured" for c in first.columns)]
    values: list[FloatArray] = [first.t_s[:, None], first.measured]
    for name, run in runs:
        names += [f"{c}_{name}" for c in run.columns]
        values.append(run.simulated)
    buffer = io.StringIO()
    np.savetxt(buffer, np.concatenate(values, axis=1), fmt="%.9g", delimiter=",", header=",".join(names), comments="")
    return buffer.getvalue().encode()


def _file(trial_id: str) -> str:
    """An id as a file name."""
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in trial_id).lstrip(".") or "trial"
