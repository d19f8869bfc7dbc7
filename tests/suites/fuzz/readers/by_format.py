"""The reader of each format that is fuzzed: assets by their reader, scene programs, plans, episodes, measurements."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path

import numpy as np

import runtime_plan
import simgap
from assetkit.readers.by_format import FORMAT_OF
from replay.recording.formats.read import read_episodes
from runtime_plan.verify import Judge
from scenec.compile import compile_program
from schemas.diagnostics import Diagnostic, InvalidInput, Severity, any_error
from tests.suites.fuzz.readers import asset
from tests.suites.fuzz.readers.note import Note

Read = Callable[[Path, Path, Note], list[Diagnostic]]
STEPS = 2_000  # of the search of each combination of a scene
SAMPLES = 16


def _scene(folder: Path, file: Path, note: Note) -> list[Diagnostic]:
    compiled = compile_program(file, None, budget=STEPS, root=folder, explain=False)
    note.made = len(compiled.scenes)
    report = compiled.report
    if not note.made and not any_error(report.diagnostics):
        note.broken.append(f"no scene and no error: {report.verdict}")
    return list(report.diagnostics)


def _plan(folder: Path, file: Path, note: Note) -> list[Diagnostic]:
    plan = runtime_plan.load(file)
    samples = runtime_plan.sample(plan, SAMPLES, seed=1)
    note.made = 1
    if not np.isfinite(samples.position_m[samples.present]).all():
        note.broken.append("a position of a present object is not finite")
    list(Judge(plan).violations(samples))
    runtime_plan.as_document(plan, samples).model_dump_json()
    return []


def _episode(folder: Path, file: Path, note: Note) -> list[Diagnostic]:
    place = folder if (folder / "meta" / "info.json").exists() or file.suffix == ".parquet" else file
    episodes = read_episodes(place)
    note.made = len(episodes)
    for episode in episodes:
        if not np.isfinite(episode.t_s).all():
            note.broken.append("a time stamp is not finite")
    return []


def _measurement(folder: Path, file: Path, note: Note) -> list[Diagnostic]:
    outcome = simgap.read(folder)
    note.made = int(outcome.value is not None)
    if outcome.value is None and not any(d.severity is Severity.ERROR for d in outcome.diagnostics):
        note.broken.append("no measurement and no error")
    return list(outcome.diagnostics)


def _guarded(read: Read) -> Callable[[Path, Path], Note]:
    """`read` as one that never raises, but for MemoryError: refusals become codes, other exceptions a trace."""

    def guarded(folder: Path, file: Path) -> Note:
        note, findings = Note(), []
        try:
            findings = read(folder, file, note)
        except InvalidInput as refused:
            findings = [refused.diagnostic]
        except MemoryError:
            raise
        except Exception:
            note.trace = traceback.format_exc()
        note.add(findings, folder)
        return note

    return guarded


ASSETS = tuple(sorted(set(FORMAT_OF.values())))
READERS: dict[str, Callable[[Path, Path], Note]] = {
    **dict.fromkeys(ASSETS, asset.read),
    "scene": _guarded(_scene),
    "plan": _guarded(_plan),
    "episode": _guarded(_episode),
    "measurement": _guarded(_measurement),
}
