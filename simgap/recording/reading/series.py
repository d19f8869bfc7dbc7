"""Reads time series: one table per trial becomes a `Trial`, as recorded; checks come later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from geom.pose import matrix_of
from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, Location, Severity, finding
from simgap.recording.reading.columns import Column, take
from simgap.recording.reading.tables import Table, unreadable
from simgap.recording.recording import Trial

_FIELDS = {
    "p": "p",
    "q_wxyz": "quat_wxyz",
    "v": "v_W",
    "w_body": "w_B",
    "command_p": "command_p",
    "command_q_wxyz": "command_quat_wxyz",
}
_JOINT_FIELDS = {"qd_": "qd", "q_": "q", "effort_": "effort", "command_": "command"}


def series_trial(
    trial_id: str,
    file: str,
    table: Table,
    columns: Sequence[Column],
    aux: Mapping[str, str],
    joints: Sequence[str],
    rate_hz: float | None,
) -> Trial:
    """The trial as recorded; without a `t` column the stamps follow from the rate.

    Raises InvalidInput (`gap/missing-column`, `gap/unreadable-table`).
    """
    taken = {column.name: take(table, column, file) for column in columns}
    lengths = {len(values) for values in taken.values()}
    if len(lengths) > 1:
        raise unreadable(file, "the columns differ in length: " + ", ".join(str(n) for n in sorted(lengths)))
    n = lengths.pop()
    t_s = taken["t"] if "t" in taken else np.arange(n) / (rate_hz or 1.0)
    fields: dict[str, FloatArray] = {
        name: np.full((n, 4 if name.endswith("wxyz") else 3), np.nan)
        for name in ("p", "quat_wxyz", "v_W", "w_B", "command_p", "command_quat_wxyz")
    } | {name: np.full((n, len(joints)), np.nan) for name in _JOINT_FIELDS.values()}
    for column in columns:
        if column.joint is not None:
            prefix = column.name[: -len(column.joint)]
            fields[_JOINT_FIELDS[prefix]][:, joints.index(column.joint)] = taken[column.name]
        elif column.name in _FIELDS:
            fields[_FIELDS[column.name]] = taken[column.name]
    if "q_xyzw" in taken:
        fields["quat_wxyz"] = np.roll(taken["q_xyzw"], 1, axis=1)
    if "w_world" in taken:
        fields["w_B"] = in_body(taken["w_world"], fields["quat_wxyz"])
    side = {name: table.columns[source] for name, source in aux.items() if source in table.columns}
    side = {k: v for k, v in side.items() if v.shape == (n,)}
    return Trial(trial_id, t_s, aux=side, file=file, **fields)  # pyright: ignore[reportArgumentType]


def in_body(vectors_W: FloatArray, quat_wxyz: FloatArray) -> FloatArray:
    """World vectors (n, 3) in body axes; NaN where the orientation is unknown."""
    known = np.isfinite(quat_wxyz).all(axis=1) & (np.abs(quat_wxyz).max(axis=1, initial=0.0) > 0.0)
    out = np.full(vectors_W.shape, np.nan)
    out[known] = np.einsum("nji,nj->ni", matrix_of(quat_wxyz[known]), vectors_W[known])
    return out


def absent_side_channels(aux: Mapping[str, str], trials: Sequence[Trial]) -> tuple[Diagnostic, ...]:
    """A warning for each side channel that some trial lacks; it only hides the effects that need it."""
    warnings: list[Diagnostic] = []
    for name, source in aux.items():
        lacking = [trial for trial in trials if name not in trial.aux]
        if lacking:
            text = f"aux '{name}' is declared as {source}; {len(lacking)} of {len(trials)} files have no such column"
            where = Location(file=lacking[0].file)
            warnings.append(finding("gap/missing-column", text, where=where, severity=Severity.WARNING))
    return tuple(warnings)
