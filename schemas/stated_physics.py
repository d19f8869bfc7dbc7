"""Mass and contact values as a source file states them, before they are checked for plausibility."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import ConfigDict

from schemas.diagnostics import Location

Combine = Literal["average", "multiply", "minimum", "maximum"]


@dataclass(frozen=True)
class StatedMass:
    """Mass, or density, of some of a model's meshes. None where the file has no statement.

    Lengths are in the unit L of `Model.meters_per_unit` and everything is posed in the frame of the model, like
    `Mesh.points`; masses are in kilograms.

    covers        `Mesh.source_path` of the meshes it is about; `triangles` counts their triangles in the whole file,
                  so that a part of them can be distinguished from all of them.
    method        the format's own words for the statement, e.g. "UsdPhysics mass".
    mass_kg       total mass.
    density       kg / L^3; only where the file states no mass.
    centre        (3,) mass centre, L.
    inertia       (3, 3) about the mass centre, axes of the model, kg L^2.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    covers: tuple[str, ...]
    triangles: int
    method: str
    where: Location
    mass_kg: float | None = None
    density: float | None = None
    centre: np.ndarray | None = None
    inertia: np.ndarray | None = None


@dataclass(frozen=True)
class StatedContact:
    """Coulomb friction and restitution of some of a model's meshes; None where the file is silent."""

    covers: tuple[str, ...]
    name: str
    method: str
    where: Location
    static_friction: float | None = None
    dynamic_friction: float | None = None
    restitution: float | None = None
    combine: Combine = "average"
