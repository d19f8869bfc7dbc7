"""What acceptance found on a package: checks, stable poses, suites with their margins; a section of its record."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from schemas.evidence import Evidence

Quantity = Literal["friction", "mass_kg"]  # what acceptance varies: friction of the own surface, mass


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class StablePose(_Section):
    """A resting orientation found by drop-settle trials.

    `quat_wxyz` is the asset frame in the world; `support_offset_m` the height of the asset origin above the support;
    `probability` the share of the trials that ended there.
    """

    quat_wxyz: tuple[float, float, float, float]
    support_offset_m: float
    probability: float


class Check(_Section):
    """One acceptance figure against its bound; JSON has infinite ones and NaN as words."""

    model_config = ConfigDict(ser_json_inf_nan="strings")

    name: str
    value: float
    bound: float
    unit: str
    passed: bool


class Margin(_Section):
    """The range of a quantity over which a suite passes, within the bounds that it is believed to have.

    `friction` is that of the object's own surface, `mass_kg` in kilograms; the other quantity has its value on record.
    """

    quantity: Quantity
    low: float
    high: float
    bounds: tuple[float, float]

    @property
    def word(self) -> str:
        """The quantity in prose."""
        return "mass" if self.quantity == "mass_kg" else "friction"

    @property
    def statement(self) -> str:
        """In words what limits it; "" where it passes within all of its bounds."""
        unit = " kg" if self.quantity == "mass_kg" else ""
        limits = [f">= {self.low:.3g}{unit}"] if self.low > self.bounds[0] else []
        limits += [f"<= {self.high:.3g}{unit}"] if self.high < self.bounds[1] else []
        return f"holds for {self.word} {' and '.join(limits)}" if limits else ""


class Corner(_Section):
    """Whether a suite passes with friction and mass at an end of their bounds each."""

    friction: float
    mass_kg: float
    passed: bool


class SuiteSection(_Section):
    """What one suite of acceptance found; `reason` says why it was not run.

    `repeats` are its figures at other steps of the engine, `corners` and `margins` those at other values of friction
    and mass; they decide nothing, but how far these values may be randomised.
    """

    name: str
    outcome: Literal["passed", "failed", "not_run"]
    reason: str = ""
    checks: tuple[Check, ...] = ()
    repeats: tuple[Check, ...] = ()
    corners: tuple[Corner, ...] = ()
    margins: tuple[Margin, ...] = ()


class AcceptanceSection(_Section):
    """What the simulator found on the package as re-read from disk: of the object as a whole, and suite by suite."""

    simulator: str
    checks: tuple[Check, ...]
    stable_poses: tuple[Evidence[StablePose], ...]
    validators: tuple[Check, ...] = ()
    suites: tuple[SuiteSection, ...] = ()
