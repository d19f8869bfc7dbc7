"""Checks of impact events: approach before, separation after, no gain of energy."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from schemas.arrays import IntArray
from schemas.diagnostics import Diagnostic, Location, Severity, finding
from schemas.measurement import Subject
from simgap.recording.recording import Impacts

_TABLE = Location(file="trajectories")
_MOST_BAD_SHARE = 0.02  # of the rows; more mean a wrong sign or unit, not a bad event
_ENERGY = 1.05


def check_impacts(impacts: Impacts, subject: Subject) -> tuple[Impacts, tuple[Diagnostic, ...]]:
    """Finite events, with a report of those that break mechanics.

    Events with a missing number, or listed twice, are left out. Events that approach with a positive normal speed, part
    with a negative one or gain kinetic energy stay: they are in the record, and show how far to trust it.
    """
    state = np.column_stack([impacts.velocity_before, impacts.velocity_after, impacts.normal, impacts.tangent])
    whole = np.isfinite(state).all(axis=1)
    _, first = np.unique(np.nan_to_num(state), axis=0, return_index=True)
    once = np.zeros(len(state), dtype=bool)
    once[first] = True
    findings: list[Diagnostic] = []
    if not whole.all():
        findings.append(_rows("gap/non-finite-rows", "events without a number dropped", int((~whole).sum())))
    if (whole & ~once).any():
        findings.append(_rows("gap/duplicate-trials", "events listed twice, left out once", int((whole & ~once).sum())))
    finite_events = _take(impacts, np.flatnonzero(whole & once))
    if not len(finite_events):
        text = "no event with all its numbers"
        return finite_events, (*findings, finding("gap/empty-trial", text, where=_TABLE, severity=Severity.ERROR))
    return finite_events, (*findings, *_mechanics(finite_events, subject))


def _mechanics(impacts: Impacts, subject: Subject) -> list[Diagnostic]:
    before, after = (
        np.einsum("ni,ni->n", impacts.normal, v) for v in (impacts.velocity_before, impacts.velocity_after)
    )
    mass = subject.mass_kg or 1.0
    inertia = subject.inertia_kgm2[2] if subject.inertia_kgm2 else 0.0
    weights = np.array([mass, mass, inertia])
    gain = (impacts.velocity_after**2 @ weights) / np.maximum(impacts.velocity_before**2 @ weights, 1e-300)
    cases = (
        ("approach with parting speed", before >= 0.0),
        ("leave still approaching", after < 0.0),
        (f"leave with more than {_ENERGY:g} times their energy", gain > _ENERGY),
    )
    n = len(impacts)
    findings: list[Diagnostic] = []
    for text, odd in cases:
        count = int(odd.sum())
        if count:
            ids = ", ".join(impacts.ids[i] for i in np.flatnonzero(odd)[:5])
            severity = Severity.WARNING if count > _MOST_BAD_SHARE * n else Severity.INFO
            headline = f"{count} of {n} events {text}: {ids}"
            findings.append(
                finding(
                    "gap/impact-inconsistent",
                    headline,
                    where=_TABLE,
                    value=count,
                    bound=_MOST_BAD_SHARE * n,
                    severity=severity,
                )
            )
    return findings


def _take(impacts: Impacts, rows: IntArray) -> Impacts:
    arrays = {f.name: getattr(impacts, f.name)[rows] for f in fields(impacts) if f.name != "ids"}
    return replace(impacts, ids=tuple(impacts.ids[i] for i in rows), **arrays)


def _rows(code: str, text: str, count: int) -> Diagnostic:
    return finding(code, f"{text}: {count}", where=_TABLE, value=count, unit="rows")
