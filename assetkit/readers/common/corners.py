"""Checks and conversions of parsed polygon data (OBJ, PLY, COLLADA): indices, corners, normals, colours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from schemas.appearance.conversions import srgb_to_linear
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.outcome import INTAKE, Repair

STRAY_SHARE = 0.1
MAX_TRIANGLES = 20_000_000  # of one file


@dataclass(frozen=True)
class Notes:
    """Findings and the repairs that answer them."""

    diagnostics: tuple[Diagnostic, ...] = ()
    repairs: tuple[Repair, ...] = ()

    def __add__(self, other: Notes) -> Notes:
        return Notes(self.diagnostics + other.diagnostics, self.repairs + other.repairs)


def repaired(diagnostic: Diagnostic, name: str, **before: float | int | str) -> Notes:
    """One finding with its repair, as an intake step records it."""
    return Notes((diagnostic,), (Repair(name=name, code=diagnostic.code, stage=INTAKE, before=before),))


def stray_faces(bad: np.ndarray, where: Location, *, points: int) -> Notes:
    """Notes for faces, marked True in (f,) `bad`, that refer to points that do not exist; they are to be dropped.

    Raises InvalidInput `asset/index-out-of-range` when a tenth of the faces or more are bad.
    """
    count, total = int(bad.sum()), len(bad)
    if count == 0:
        return Notes()
    fatal = count >= STRAY_SHARE * total
    diagnostic = finding(
        "asset/index-out-of-range",
        f"{count} of {total} faces refer to points outside the {points} there are",
        where=where,
        value=count,
        bound=STRAY_SHARE * total,
        unit="faces",
        severity=None if fatal else Severity.WARNING,
    )
    if fatal:
        raise InvalidInput(diagnostic)
    return repaired(diagnostic, "index_out_of_range", faces=total, bad_faces=count)


def empty_faces(count: int, where: Location) -> Notes:
    """Notes for `count` face records with fewer than three corners, which are to be dropped."""
    if count == 0:
        return Notes()
    headline = f"{count} face records have fewer than three corners"
    diagnostic = finding("asset/empty-face", headline, where=where, value=count, bound=0, unit="faces")
    return repaired(diagnostic, "empty_face_record", records=count)


def compact(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`points` that `triangles` use, in source order, and the (m, 3) int32 triangles renumbered to match."""
    used = np.zeros(len(points), dtype=bool)
    used[triangles] = True
    renumber = np.cumsum(used) - 1
    return np.ascontiguousarray(points[used]), renumber[triangles].astype(np.int32)


def unit_normals(
    normals: np.ndarray, points: np.ndarray, triangles: np.ndarray, where: Location
) -> tuple[np.ndarray, Notes]:
    """(m, 3, 3) float32 unit corner normals; zero or non-finite ones become the normal of their triangle.

    None of OBJ, PLY and COLLADA requires unit length, so other lengths are normalised without a finding; nor is
    anything lost where a triangle has no area and hence no normal.
    """
    with np.errstate(all="ignore"):
        lengths = np.linalg.norm(normals, axis=2, keepdims=True)
        unit = normals / lengths
    bad = np.logical_not(np.isfinite(unit).all(axis=2) & (lengths[..., 0] > 1e-12))
    if not bad.any():
        return unit.astype(np.float32), Notes()
    a, b, c = (points[triangles[:, i]] for i in range(3))
    faces = np.cross(b - a, c - a)
    area = np.linalg.norm(faces, axis=1, keepdims=True)
    flat = area[:, 0] <= 1e-12 * np.maximum(np.sum((b - a) ** 2, axis=1), np.sum((c - a) ** 2, axis=1))
    faces = np.where(flat[:, None], [0.0, 0.0, 1.0], faces / np.where(area > 0, area, 1.0))
    unit = np.where(bad[..., None], faces[:, None], unit).astype(np.float32)
    count, total = int((bad & ~flat[:, None]).sum()), bad.size
    if count == 0:
        return unit, Notes()
    diagnostic = finding(
        "asset/bad-normals",
        f"{count} of {total} corner normals are zero or not finite",
        where=where,
        value=count,
        bound=0,
        unit="corners",
    )
    return unit, repaired(diagnostic, "bad_normals", corners=total, bad_corners=count)


def usable_colors(rgba: np.ndarray, where: Location) -> tuple[np.ndarray, Notes]:
    """Linear (n, 4) float64 colours from display values in 0..1; colours that are not finite become white."""
    bad = np.logical_not(np.isfinite(rgba).all(axis=1))
    linear = np.where(bad[:, None], 1.0, rgba)
    linear = np.concatenate([srgb_to_linear(linear[:, :3]), np.clip(linear[:, 3:], 0.0, 1.0)], axis=1)
    if not bad.any():
        return linear, Notes()
    diagnostic = finding(
        "asset/nonfinite-colors",
        f"{bad.sum()} of {len(bad)} vertex colours are not finite, first at vertex {np.flatnonzero(bad)[0]}",
        where=where,
        value=int(bad.sum()),
        bound=0,
        unit="vertices",
    )
    return linear, repaired(diagnostic, "nan_vertex_color", bad_colors=int(bad.sum()))
