"""Canonical columns: which each kind of measurement needs, and a table's columns under canonical names."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.measurement import Kind, MeasurementSpec
from simgap.recording.reading.tables import Table
from simgap.recording.reading.yaml_text import YamlDocument

SERIES: dict[str, int] = {
    "t": 1,
    "p": 3,
    "q_wxyz": 4,
    "q_xyzw": 4,
    "v": 3,
    "w_body": 3,
    "w_world": 3,
    "command_p": 3,
    "command_q_wxyz": 4,
}
PER_JOINT = ("qd_", "q_", "effort_", "command_")  # + joint name; the longer prefix first
IMPACT: dict[str, int] = {
    "id": 1,
    "pose_before": 3,
    "velocity_before": 3,
    "pose_after": 3,
    "velocity_after": 3,
    "normal_jacobian": 3,
    "tangent_jacobian": 3,
}
PUSH: dict[str, int] = {
    "p": 3,
    "q_wxyz": 4,
    "q_xyzw": 4,
    "tip_t": 1,
    "tip_p": 3,
    "tip_q_wxyz": 4,
    "force_t": 1,
    "force": 0,  # 2 or 3
}
WIDTHS: dict[Kind, dict[str, int]] = {
    "free_body": SERIES,
    "mechanism": SERIES,
    "tracking": SERIES,
    "impact": IMPACT,
    "push": PUSH,
}
NEEDED: dict[Kind, tuple[tuple[str, ...], ...]] = {  # one of each group
    "free_body": (("p",), ("q_wxyz", "q_xyzw")),
    "mechanism": (("q_<joint>",),),
    "tracking": (("command_<joint>", "command_p"), ("q_<joint>", "p")),
    "impact": (("velocity_before",), ("velocity_after",), ("normal_jacobian",), ("tangent_jacobian",)),
    "push": (("p",), ("q_wxyz", "q_xyzw"), ("tip_t",), ("tip_p",)),
}


@dataclass(frozen=True)
class Column:
    """One of our columns: its name, joint (for per-joint names), and the file's column(s)."""

    name: str
    joint: str | None
    sources: tuple[str, ...]
    width: int  # 0: free


def declared_columns(
    spec: MeasurementSpec, measured: Sequence[str], joints: Sequence[str], document: YamlDocument
) -> tuple[tuple[Column, ...], tuple[Diagnostic, ...]]:
    """The columns of the file in our names, with findings: unknown names, unknown joints, wrong counts, gaps.

    `measured` are the subject's `joints` that have a position or a command.
    """
    columns: list[Column] = []
    findings: list[Diagnostic] = []
    for name, given in spec.columns.items():
        sources = (given,) if isinstance(given, str) else given
        where = document.place(("columns", name), of_key=True)
        joint = None if name in WIDTHS[spec.kind] else _joint_of(name, spec.kind)
        if name not in WIDTHS[spec.kind] and joint is None:
            findings.append(_unknown(name, spec.kind, joints, where))
            continue
        if joint is not None and joint not in joints:
            findings.append(_unknown_joint(name, joint, joints, where))
            continue
        if joint is not None and joint not in measured:
            text = f"'{name}': joint '{joint}' has neither q_{joint} nor command_{joint}"
            findings.append(finding("gap/missing-column", text, where=where))
            continue
        width = 1 if joint is not None else WIDTHS[spec.kind][name]
        if (len(sources) != 1 and width not in (0, len(sources))) or not sources:
            text = f"'{name}' has {width or 'some'} numbers per row, {len(sources)} columns are given"
            findings.append(finding("gap/invalid-value", text, where=where, value=len(sources), bound=width))
            continue
        columns.append(Column(name, joint, sources, width))
    names = {c.name for c in columns} | {c.name.removesuffix(c.joint) + "<joint>" for c in columns if c.joint}
    for group in NEEDED[spec.kind]:
        if not names.intersection(group) and not findings:
            text = f"a measurement of kind {spec.kind} needs the column {' or '.join(group)}"
            findings.append(finding("gap/missing-column", text, where=document.place(("columns",), of_key=True)))
    return tuple(columns), tuple(findings)


def take(table: Table, column: Column, file: str) -> FloatArray:
    """(n,) or (n, width) of one column of ours.

    Raises InvalidInput (`gap/missing-column`, `gap/unreadable-table`) when the file lacks it or holds another width.
    """
    absent = [s for s in column.sources if s not in table.columns]
    if absent:
        raise InvalidInput(
            finding(
                "gap/missing-column",
                f"'{column.name}' is declared as {', '.join(column.sources)}; the file has no {', '.join(absent)}",
                where=Location(file=file),
            )
        )
    parts = [table.columns[s] for s in column.sources]
    if len({len(p) for p in parts}) > 1:
        raise _wrong(file, f"the columns of '{column.name}' differ in length")
    values = np.column_stack(parts)
    if column.width not in (0, values.shape[1]) and len(values):
        raise _wrong(file, f"'{column.name}' needs {column.width} numbers per row, the file gives {values.shape[1]}")
    if not len(values):
        return np.empty(0) if column.width == 1 else np.empty((0, column.width or values.shape[1]))
    return values[:, 0] if column.width == 1 else values


def sources_of(columns: Sequence[Column], aux: Mapping[str, str]) -> frozenset[str]:
    """Every column of a file that a channel needs."""
    return frozenset(s for c in columns for s in c.sources) | frozenset(aux.values())


def _joint_of(name: str, kind: Kind) -> str | None:
    if kind in ("impact", "push"):
        return None
    prefix = next((p for p in PER_JOINT if name.startswith(p)), None)
    return name[len(prefix) :] or None if prefix else None


def _unknown(name: str, kind: Kind, joints: Sequence[str], where: Location) -> Diagnostic:
    series = kind not in ("impact", "push")
    known = [*WIDTHS[kind], *(p + j for p in PER_JOINT for j in joints if series)]
    near = difflib.get_close_matches(name, known, n=1)
    names = [*WIDTHS[kind], *(f"{p}<joint>" for p in PER_JOINT if series)]
    hint = f"did you mean '{near[0]}'?" if near else f"known here: {', '.join(names)}"
    return finding("gap/unknown-column", f"'{name}' is no column of kind {kind}; {hint}", where=where)


def _unknown_joint(name: str, joint: str, joints: Sequence[str], where: Location) -> Diagnostic:
    text = f"'{name}': the subject has no joint '{joint}'; it has {', '.join(joints) or 'none'}"
    return finding("gap/unknown-column", text, where=where)


def _wrong(file: str, text: str) -> InvalidInput:
    return InvalidInput(finding("gap/unreadable-table", text, where=Location(file=file)))
