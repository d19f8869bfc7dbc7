"""What a case hides, as the scorer reads it; kept apart from the folder that the finder reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

Family = Literal["control", "single", "two", "twin", "outside", "left_out"]
FAMILIES: tuple[Family, ...] = ("control", "single", "two", "twin", "outside", "left_out")
SAME = 9.0  # noncentrality at which the better of two equal causes is still taken for the other in 7 of 100 cases
CLOSE = 100.0  # to doubt between them is right up to here


@dataclass(frozen=True)
class HiddenEffect:
    """One hidden cause: its name, joint ("" for the whole log), and library parameters of the same meaning."""

    name: str
    joint: str = ""
    parameters: dict[str, float] = field(default_factory=dict)
    strength: float = 0.0


@dataclass(frozen=True)
class Truth:
    """The truth of a case.

    accept      effects that these very data cannot separate from a hidden one; near: such that to doubt is right.
    rivals      noncentrality of a likelihood ratio test between the hidden cause and each promising rival's best refit.
    visible     the same between the hidden cause and the believed model with its numbers free within their tolerance.
    miss        noise levels by which the believed model misses when restarted every `horizon_s` from true readings;
                whole: when started once per trial.
    left_out    library effects that the finder must not have.
    twin        the twin that the case was drawn for; `accept` is what was computed.
    """

    number: int
    measurement: str
    family: Family
    kind: str
    scene: str
    effects: tuple[HiddenEffect, ...] = ()
    accept: tuple[str, ...] = ()
    near: tuple[str, ...] = ()
    rivals: dict[str, float] = field(default_factory=dict)
    visible: float = 0.0
    level: str = ""
    level_reached: bool = True
    miss: float = 0.0
    miss_whole: float = 0.0
    horizon_s: float = 0.0
    sigma: float = 0.0
    left_out: tuple[str, ...] = ()
    twin: str = ""
    control: str = ""
    log: dict[str, Any] = field(default_factory=dict)

    def with_rivals(self, visible: float, noncentralities: Mapping[str, float]) -> Truth:
        """The truth with what else explains the readings, nearest first."""
        return replace(
            self,
            visible=visible,
            rivals={name: float(f"{left:.4g}") for name, left in noncentralities.items()},
            accept=tuple(name for name, left in noncentralities.items() if left < SAME),
            near=tuple(name for name, left in noncentralities.items() if SAME <= left < CLOSE),
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return asdict(self)


def truth_from(data: dict[str, Any]) -> Truth:
    """A truth from its JSON."""
    effects = tuple(HiddenEffect(**e) for e in data["effects"])
    listed = {key: tuple(data[key]) for key in ("accept", "near", "left_out")}
    return Truth(**{**data, **listed, "effects": effects})
