"""An effect as data: formula, source, parameters, look-alikes, hook, and how each kind of measurement shows it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from schemas.measurement import Kind
from sim.dynamics.hooks import EffortMap, Hook
from sim.effects.candidacy import ImpactCandidacy, MechanismCandidacy, PushCandidacy, TossCandidacy

PackageField = Literal["mass_kg", "centre_of_mass_m", "inertia_kgm2", "friction", "restitution"]
JointField = Literal["friction", "damping", "lower", "upper", "effort"]


@dataclass(frozen=True)
class Scan:
    """Values of a shape at which a search probes an effect: `count` between its bounds, evenly or by ratio.

    They begin at `from_low` times the lower bound and end at `to_high` times the upper one.
    """

    count: int
    by_ratio: bool = False
    from_low: float = 1.0
    to_high: float = 1.0


@dataclass(frozen=True)
class Parameter:
    """A number of an effect: SI unit (also the end of its name), bounds of what is plausible, value without effect.

    is_shape   it has no meaning while the effect is absent: where on a range the law acts, not how strongly.
    is_phase   a shape of a wave: sine and cosine give it in closed form.
    scan       of a shape that a linear step from one value does not find.
    """

    name: str
    unit: str
    low: float
    high: float
    null: float
    is_shape: bool = False
    is_phase: bool = False
    scan: Scan | None = None


IN_LOOP = Parameter("in_loop", "1", 0.0, 1.0, 0.0, is_shape=True)  # 0: on the way to the controller, 1: after it


@dataclass(frozen=True)
class Confusable:
    """Another effect with a like signature, and the experiment that separates the two.

    same_for_one_joint   in the log of a single joint the two are one law, whatever the motion: no fit separates them.
    """

    effect: str
    experiment: str
    same_for_one_joint: bool = False


@dataclass(frozen=True)
class Export:
    """Where files carry an effect.

    usd, urdf       attributes that carry it; empty where none can.
    package         field of `schemas.measured_physics.MeasuredPhysics`.
    urdf_contact    child of `<contact>` by parameter.
    urdf_joint      field of `schemas.measured_physics.MeasuredJoint` by parameter.
    urdf_least      smallest value that URDF allows there.
    only_reached    of `urdf_joint` only values with an interval count: the trials came to no other end of travel.
    left_out        why no file carries it, where its family does not say so.
    """

    usd: str = ""
    urdf: str = ""
    package: PackageField | None = None
    urdf_contact: Mapping[str, str] = field(default_factory=dict)
    urdf_joint: Mapping[str, JointField] = field(default_factory=dict)
    urdf_least: float = -math.inf
    only_reached: bool = False
    left_out: str = ""


@dataclass(frozen=True)
class Effect:
    """One physical effect.

    kinds        measurements that can reveal it.
    formula, source   the law as text, and where it comes from.
    reveals      what in the data shows it.
    mechanism, free_body, impact, push   how it is searched for in each of `kinds`.
    plot_against   the state over which a report draws the effort that it explains.
    in_loop      its hook where parameter `IN_LOOP` is 1: the effect lies inside the loop of a drive with feedback.
    """

    name: str
    kinds: tuple[Kind, ...]
    formula: str
    source: str
    reveals: str
    parameters: tuple[Parameter, ...]
    confusables: tuple[Confusable, ...]
    hook: Hook
    mechanism: MechanismCandidacy = field(default_factory=MechanismCandidacy)
    free_body: TossCandidacy = field(default_factory=TossCandidacy)
    impact: ImpactCandidacy = field(default_factory=ImpactCandidacy)
    push: PushCandidacy = field(default_factory=PushCandidacy)
    plot_against: Literal["speed", "position", "input"] = "speed"
    export: Export = field(default_factory=Export)
    in_loop: EffortMap | None = None

    def hook_at(self, values: Mapping[str, float]) -> Hook:
        """The hook for these parameter values."""
        return self.in_loop if self.in_loop is not None and values.get(IN_LOOP.name, 0.0) > 0.5 else self.hook

    @property
    def family(self) -> str:
        """`contact`, `body`, `world`, `joint`, `actuator`, `sensor` or `robot`."""
        return self.name.partition(".")[0]

    @property
    def shapes(self) -> tuple[str, ...]:
        """Names of the parameters that shape the law."""
        return tuple(p.name for p in self.parameters if p.is_shape)

    @property
    def phase(self) -> str | None:
        """Name of the parameter that is a phase."""
        return next((p.name for p in self.parameters if p.is_phase), None)

    def null(self) -> dict[str, float]:
        """Parameter values at which the effect is absent."""
        return {p.name: p.null for p in self.parameters}

    def __reduce__(self) -> tuple[Callable[[str], Effect], tuple[str]]:
        """A stored effect is its name: results that are kept on disk hold no functions."""
        from sim.effects.library import effect  # The library imports this module.

        return effect, (self.name,)
