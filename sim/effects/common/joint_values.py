"""Helpers for effects that change one value of one joint or link of a mechanism model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from schemas.arrays import FloatArray
from schemas.sim_gap.extension import Place
from sim.dynamics.mechanism import MechanismModel
from sim.dynamics.tree import Link


def joint_index(model: MechanismModel, where: Place) -> int:
    """Position of the joint named by `where`; the first one if it names none. Raises KeyError for an unknown name."""
    if where.joint is None:
        return 0
    names = [link.name for link in model.tree]
    if where.joint not in names:
        raise KeyError(f"no joint '{where.joint}'; there are {', '.join(names)}")
    return names.index(where.joint)


def with_joint_value(model: MechanismModel, values: FloatArray, where: Place, value: float) -> FloatArray:
    """A copy of per-joint `values` (j,) with that of `where` replaced."""
    changed = values.copy()
    changed[joint_index(model, where)] = value
    return changed


def with_link(model: MechanismModel, where: Place, change: Callable[[Link], Link]) -> MechanismModel:
    """The model with the link of `where` changed."""
    at = joint_index(model, where)
    return replace(model, tree=tuple(change(link) if i == at else link for i, link in enumerate(model.tree)))
