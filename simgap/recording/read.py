"""Reads a measurement folder: checked trials in SI units and canonical frames, or the findings that prevent it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.measurement import MeasurementSpec, SensorNoise
from schemas.outcome import Outcome
from simgap.recording.checks.check import Setting
from simgap.recording.checks.impacts import check_impacts
from simgap.recording.checks.order import check_series
from simgap.recording.checks.pushes import check_pushes
from simgap.recording.checks.splits import check_split
from simgap.recording.reading.columns import Column, declared_columns, sources_of
from simgap.recording.reading.contact import contact_findings
from simgap.recording.reading.folder import SPEC_FILE, content_hash, inside, trajectory_files
from simgap.recording.reading.impact import impact_rows
from simgap.recording.reading.push import push_trial
from simgap.recording.reading.series import absent_side_channels, series_trial
from simgap.recording.reading.spec import read_spec
from simgap.recording.reading.subject import JointInfo, subject_files, subject_findings, subject_joints
from simgap.recording.reading.trials import Parts, each, tables_by_trial
from simgap.recording.reading.yaml_text import parse_yaml
from simgap.recording.recording import Impacts, Push, Trial


@dataclass(frozen=True)
class Measurement:
    """What was measured, ready for simulation.

    trials        time series of the kinds `free_body`, `mechanism` and `tracking`, in natural order of their ids.
    impacts, pushes   the records of those two kinds instead.
    joints        names of the measured joints, base to tip: the columns of `Trial.q`.
    noise         one standard deviation of each channel: declared, else estimated, else None.
    content_hash  SHA-256 over every file that was read.
    """

    spec: MeasurementSpec
    trials: tuple[Trial, ...]
    root: Path
    content_hash: str
    joints: tuple[str, ...] = ()
    noise: SensorNoise = field(default_factory=SensorNoise)
    impacts: Impacts | None = None
    pushes: tuple[Push, ...] = ()

    @property
    def trial_ids(self) -> tuple[str, ...]:
        """Ids of all trials, pushes or impacts."""
        if self.impacts is not None:
            return self.impacts.ids
        return tuple(p.id for p in self.pushes) or tuple(t.id for t in self.trials)


Columns = tuple[Column, ...]
Joints = tuple[JointInfo, ...]
Built = tuple[Measurement, tuple[Diagnostic, ...]]


def read(folder: Path) -> Outcome[Measurement]:
    """The measurement in `folder` with every finding about it; `value` is None when an error leaves nothing to use.

    Files that cannot be read, empty trials and copies are left out with a warning while others remain. What is repaired
    and what is only reported stands in `docs/reference/measurement.md`.
    """
    try:
        return _read(Path(folder).resolve())
    except InvalidInput as refused:
        return Outcome(None, (refused.diagnostic,))


def _read(root: Path) -> Outcome[Measurement]:
    spec_path = inside(root, SPEC_FILE, Location(file=SPEC_FILE))
    if not spec_path.is_file():
        return Outcome(None, (finding("gap/missing-file", f"'{SPEC_FILE}' is no regular file"),))
    document = parse_yaml(spec_path.read_bytes(), SPEC_FILE)
    spec, problems = read_spec(document)
    if spec is None:
        return Outcome(None, problems)
    findings = [*subject_findings(spec, document), *contact_findings(spec, document)]
    every_joint = subject_joints(root, spec.subject, document)
    joints = tuple(j for j in every_joint if {f"q_{j.name}", f"command_{j.name}"} & set(spec.columns))
    columns, more = declared_columns(spec, [j.name for j in joints], [j.name for j in every_joint], document)
    findings += more
    if _is_series(spec) and "t" not in spec.columns and spec.rate_hz is None:
        text = "neither a column 't' nor 'rate_hz' tells the time"
        findings.append(finding("gap/no-clock", text, where=document.place(("columns",), of_key=True)))
    if _refused(findings):
        return Outcome(None, tuple(findings))
    paths = trajectory_files(root)
    hashed = content_hash(root, [spec_path, *paths, *subject_files(root, spec.subject, document)])
    trials, more = tables_by_trial(root, paths, spec.kind, sources_of(columns, spec.aux))
    findings += more
    if _refused(findings):
        return Outcome(None, tuple(findings))
    bare = Measurement(spec, (), root, hashed, tuple(j.name for j in joints), spec.sensor_noise)
    fill = {"impact": _with_impacts, "push": _with_pushes}.get(spec.kind, _with_series)
    measurement, more = fill(bare, trials, columns, joints)
    findings += more
    in_files = measurement.impacts.ids if measurement.impacts is not None else tuple(trials)
    findings += check_split(spec, in_files, measurement.trial_ids, document)
    return Outcome(None if _refused(findings) or not measurement.trial_ids else measurement, tuple(findings))


def _is_series(spec: MeasurementSpec) -> bool:
    return spec.kind not in ("impact", "push")


def _refused(findings: list[Diagnostic]) -> bool:
    return any(d.severity is Severity.ERROR for d in findings)


def _with_series(bare: Measurement, trials: Mapping[str, Parts], columns: Columns, joints: Joints) -> Built:
    spec, names = bare.spec, [joint.name for joint in joints]

    def build(trial_id: str, parts: Parts) -> Trial:
        file, table = parts[""]
        return series_trial(trial_id, file, table, columns, spec.aux, names, spec.rate_hz)

    raw, refused = each(trials, build)
    clean, noise, findings = check_series(Setting(spec, joints), raw) if raw else ((), spec.sensor_noise, ())
    return replace(bare, trials=clean, noise=noise), (*refused, *absent_side_channels(spec.aux, raw), *findings)


def _with_impacts(bare: Measurement, trials: Mapping[str, Parts], columns: Columns, joints: Joints) -> Built:
    rows = impact_rows([parts[""] for parts in trials.values()], columns)
    impacts, findings = check_impacts(rows, bare.spec.subject)
    return replace(bare, impacts=impacts), findings


def _with_pushes(bare: Measurement, trials: Mapping[str, Parts], columns: Columns, joints: Joints) -> Built:
    raw, refused = each(trials, lambda trial_id, parts: push_trial(trial_id, parts, columns))
    clean, findings = check_pushes(raw)
    return replace(bare, pushes=clean), (*refused, *findings)
