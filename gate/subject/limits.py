"""Per-axis limits of a joint (PhysicsLimitAPI), and the instances of multiple-apply schemas."""

from __future__ import annotations

from typing import Any

import numpy as np

from gate.subject.values import number


def instances(prim: Any, schema: str) -> tuple[str, ...]:
    """Instance names of an applied multiple-apply schema, such as `PhysicsDriveAPI`."""
    return tuple(s.partition(":")[2] for s in prim.GetAppliedSchemas() if s.startswith(f"{schema}:"))


def axis_limits(prim: Any) -> dict[str, tuple[float, float]]:
    """(low, high) per axis that has a PhysicsLimitAPI; infinite where nothing is stated."""
    return {
        axis: (
            number(prim, f"limit:{axis}:physics:low", -np.inf),
            number(prim, f"limit:{axis}:physics:high", np.inf),
        )
        for axis in instances(prim, "PhysicsLimitAPI")
    }
