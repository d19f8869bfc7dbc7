"""Experiments on engines: PyBullet passes them as it is set up here, and each wrong set-up is seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from schemas.physics import CollisionShape
from sim.bullet.body import BulletBodyRollout
from sim.dynamics.body_rollout import BodyModel, BodyMotion, BodyRollout, BodyWindows, BodyWrench
from sim.dynamics.hooks import Params
from simgap.sanity.convention_checks import body_engine_checks

BOX = BodyModel(
    shapes=(CollisionShape("box", (0.1, 0.06, 0.04), np.eye(4)),),
    mass_kg=0.37,
    com_B=np.array([0.01, -0.005, 0.002]),
    inertia_B=np.array([[8e-4, 5e-5, 0.0], [5e-5, 9e-4, 2e-5], [0.0, 2e-5, 1e-3]]),
    friction=0.36,
    restitution=0.25,
)
FINE_S = 1.0 / 960.0  # as in `mana gap find`: coefficients are blurred by the engine's usual step
NAMES = {
    "mass_held",
    "inertia_held",
    "damping_off",
    "gravity_held",
    "friction_of_pair",
}


class Altered(BodyRollout):
    """PyBullet with one convention wrong."""

    def __init__(self, engine: BulletBodyRollout, **changed: Callable[[Any], Any]) -> None:
        self.engine, self.changed = engine, changed

    def rollout(
        self,
        model: BodyModel,
        windows: BodyWindows,
        wrenches: Sequence[tuple[BodyWrench, Params]] = (),
        finer: float = 1.0,
    ) -> BodyMotion:
        numbers = {name: change(getattr(model, name)) for name, change in self.changed.items()}
        return self.engine.rollout(replace(model, **numbers), windows, wrenches, finer)

    def close(self) -> None:
        self.engine.close()


def test_the_engine_holds_what_it_was_given():
    with BulletBodyRollout(FINE_S) as engine:
        found = {t.name: (t.status, t.evidence) for t in body_engine_checks(engine, BOX)}
    assert set(found) == NAMES
    assert {n for n, (status, _) in found.items() if status != "ok"} == set(), found


@pytest.mark.parametrize(
    ("field", "change", "trap"),
    [
        ("inertia_B", lambda i: 0.84 * i, "inertia_held"),  # what a URDF without its flag does
        ("friction", lambda mu: 0.5 * mu, "friction_of_pair"),  # the pair's coefficients multiplied
        ("mass_kg", lambda m: 1.1 * m, "mass_held"),
    ],
)
def test_a_wrong_convention_is_seen(field: str, change, trap: str):
    with BulletBodyRollout(FINE_S) as engine:
        found = {t.name: t.status for t in body_engine_checks(Altered(engine, **{field: change}), BOX)}
    assert found[trap] == "suspect"
