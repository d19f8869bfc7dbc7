"""One cause: from a strength and the sizes of the believed motion to what differs from belief (`Hidden`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden, Plant
from tests.suites.gap2.generate.scenes import Sizes

Draws = np.ndarray  # (4,) uniform in 0 to 1: the shape of a cause, equal at every strength


@dataclass(frozen=True)
class Where:
    """The believed mechanism, the joint on which a cause acts, its sizes there and the cause's draws."""

    plant: Plant
    joint: int
    sizes: Sizes
    draws: Draws

    def believed(self, which: Number) -> float:
        """A believed number of the joint."""
        return self.plant.number(self.joint, which)

    @property
    def way(self) -> float:
        """1 or -1, drawn."""
        return 1.0 if self.draws[0] < 0.5 else -1.0

    def count(self, fewest: float, most: float) -> float:
        """Repeats per rad (m) such that the travel holds `fewest` to `most` of them."""
        return float(2.0 * np.pi * (fewest + self.draws[1] * (most - fewest)) / (2.0 * self.sizes.reach))

    def changed(self, **numbers: float) -> Hidden:
        """Other numbers of the joint, by the names of `Number`."""
        return Hidden(self.joint, {Number[name]: value for name, value in numbers.items()})

    def share(self, strength: float) -> float:
        """A factor that is off by `strength`, to the drawn side."""
        return 1.0 + self.way * strength


@dataclass(frozen=True)
class Cause:
    """One cause.

    name      the library's, or `outside.<word>`.
    scenes    where data can show it.
    least, most   strengths; a cause that is large at its least gets a noisier sensor.
    hidden    what it is at a strength.
    checked   library parameters that are numbers of what is hidden.
    rubs      needs dry friction that the owner knows of; supply: needs the supply's log.
    whole     acts on the whole log or world: the verdict names no joint.
    """

    name: str
    scenes: tuple[str, ...]
    hidden: Callable[[float, Where], Hidden]
    checked: Callable[[Hidden], Mapping[str, float]] = lambda hidden: {}
    least: float = 1e-5
    most: float = 1.0
    rubs: bool = False
    supply: bool = False
    whole: bool = False
