"""Margins: where a suite stops passing, found on a made-up suite whose limit is known."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import pytest

from assetkit.acceptance.suites.margins import variations
from assetkit.acceptance.suites.policy import POLICY
from assetkit.acceptance.suites.suite import Conditions, Subject, SuiteRun, at_least
from schemas.asset import Role
from sim.fake import FakeSimulator
from sim.port import Simulator
from tests.assetkit.acceptance.suites.subjects import subject
from tests.assetkit.affordances.test_grasps import THINGS

BOUNDS = {"friction_bounds": (0.1, 0.8), "mass_bounds_kg": (0.05, 1.0)}


@dataclass
class HoldsByFriction:
    """Passes where 2 mu F carries the weight; F in newtons."""

    force_n: float
    name: str = "holds"
    roles: frozenset[Role] = frozenset()
    codes: tuple[str, ...] = ()
    varies: bool = True
    least_hz: float = 0.0
    runs: list[Conditions] = field(default_factory=list[Conditions])

    def obstacle(self, subject: Subject) -> str:
        return ""

    def run(self, subject: Subject, simulator: Simulator, conditions: Conditions) -> SuiteRun:
        self.runs.append(conditions)
        body = subject.under(conditions).body
        ratio = 2.0 * body.contact.dynamic_friction * self.force_n / (body.mass.mass_kg * 9.81)
        fast = at_least("rate", 1.0 / conditions.step_s, self.least_hz, "Hz")
        return SuiteRun((at_least("holding", ratio, 1.0, ""), fast))


def test_the_ends_of_the_bounds_that_pass_limit_nothing() -> None:
    suite = HoldsByFriction(force_n=1000.0)
    varied = variations(suite, replace(subject(THINGS["box"]), **BOUNDS), FakeSimulator())
    assert [margin.statement for margin in varied.margins] == ["", ""]
    assert [corner.passed for corner in varied.corners] == [True] * 4
    assert len(suite.runs) == len(POLICY.steps_hz) + 4  # Between corners that pass nothing is tried.


def test_the_limit_is_found_and_lies_on_the_safe_side() -> None:
    body = THINGS["box"]  # 0.2 kg, friction 0.4
    suite = HoldsByFriction(force_n=0.2 * 9.81 / (2.0 * 0.25))  # so that it holds from 0.25 on
    varied = variations(suite, replace(subject(body), **BOUNDS), FakeSimulator())
    friction, mass = varied.margins
    assert 0.25 <= friction.low <= 0.25 * (1.0 + POLICY.margin_share)
    assert friction.high == 0.8
    assert friction.statement == f"holds for friction >= {friction.low:.3g}"
    assert mass.low == 0.05
    assert mass.statement == f"holds for mass <= {mass.high:.3g} kg"
    assert 0.32 / (1.0 + POLICY.margin_share) <= mass.high <= 0.32  # 0.4 / 0.25 times 0.2 kg
    # Corners: a fifth of the mass makes up for a quarter of the friction.
    assert [(c.friction, c.mass_kg, c.passed) for c in varied.corners] == [
        (0.1, 0.05, True),
        (0.1, 1.0, False),
        (0.8, 0.05, True),
        (0.8, 1.0, False),
    ]


def test_a_step_at_which_it_fails_is_recorded() -> None:
    varied = variations(HoldsByFriction(force_n=1000.0, least_hz=200.0), subject(THINGS["box"]), FakeSimulator())
    assert [(check.name, check.passed) for check in varied.repeats] == [
        ("passes_at_120_hz", False),
        ("passes_at_480_hz", True),
    ]
    assert varied.margins == ()
    assert varied.corners == ()


def test_a_body_under_other_conditions_keeps_its_shape_of_inertia() -> None:
    varied = subject(THINGS["box"]).under(Conditions(mass_kg=0.6)).body
    assert varied.mass.mass_kg == pytest.approx(0.6)
    assert varied.mass.inertia_kgm2 == pytest.approx(3.0 * THINGS["box"].mass.inertia_kgm2)
