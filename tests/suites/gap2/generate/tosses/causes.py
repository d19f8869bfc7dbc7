"""What a toss can hide: library effects, outside causes, and which are hidden as twins or two at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tests.suites.gap2.generate.arrays import Array
from tests.suites.gap2.generate.bodies import GRAVITY, Box, HiddenInBox


def vector(values: Array) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


@dataclass(frozen=True)
class TossCause:
    """A cause: how it is made from a strength and a way (unit vector (3,)), and its library parameters."""

    name: str
    slides: bool | None
    make: Callable[[float, Array, Box], HiddenInBox]
    checked: Callable[[HiddenInBox], Mapping[str, float]] = lambda hidden: {}
    most: float = 1.0


LIBRARY: tuple[TossCause, ...] = (
    TossCause(
        "world.gravity_magnitude",
        False,
        lambda s, way, box: HiddenInBox(gravity=GRAVITY * (1.0 + np.sign(way[0]) * s)),
        lambda h: {"gravity_mps2": h.gravity},
        0.5,
    ),
    TossCause("world.gravity_tilt", None, lambda s, way, box: HiddenInBox(tilt=(s * way[0], s * way[1])), most=0.2),
    TossCause(
        "world.linear_drag",
        False,
        lambda s, way, box: HiddenInBox(drag=s * box.mass_kg * 3.0),
        lambda h: {"drag_Nspm": h.drag},
    ),
    TossCause(
        "world.quadratic_drag",
        False,
        lambda s, way, box: HiddenInBox(square_drag=s * box.mass_kg * 2.0),
        lambda h: {"drag_Ns2pm2": h.square_drag},
    ),
    TossCause(
        "world.constant_force",
        None,
        lambda s, way, box: HiddenInBox(force=vector(s * box.mass_kg * GRAVITY * way * [1, 1, 0])),
        most=0.2,
    ),
    TossCause(
        "contact.friction",
        True,
        lambda s, way, box: HiddenInBox(mu=box.mu * (1.0 + np.sign(way[0]) * s)),
        lambda h: {"mu": h.mu or 0.0},
        0.6,
    ),
    TossCause(
        "body.com_offset",
        False,
        lambda s, way, box: HiddenInBox(com=vector(0.3 * s * box.size_m * way)),
        lambda h: dict(zip(("x_m", "y_m", "z_m"), h.com, strict=True)),
    ),
    TossCause(
        "sensor.scale",
        None,
        lambda s, way, box: HiddenInBox(scale=1.0 + np.sign(way[0]) * s),
        lambda h: {"factor": h.scale},
        0.3,
    ),
    TossCause(
        "sensor.clock_skew",
        None,
        lambda s, way, box: HiddenInBox(clock=1.0 + np.sign(way[0]) * s),
        lambda h: {"factor": h.clock},
        0.3,
    ),
)
OUTSIDE: tuple[TossCause, ...] = (
    TossCause("outside.lift", False, lambda s, way, box: HiddenInBox(lift=s * box.mass_kg)),
    TossCause("outside.gusts", False, lambda s, way, box: HiddenInBox(gust=5.0 * s * box.mass_kg * GRAVITY)),
    TossCause("outside.friction_by_place", True, lambda s, way, box: HiddenInBox(rough=s, rough_count=25.0), most=0.9),
    TossCause("outside.friction_fades", True, lambda s, way, box: HiddenInBox(fading=s), most=0.9),
)
_BY_NAME = {cause.name: cause for cause in (*LIBRARY, *OUTSIDE)}
# Of boxes that tumble: no two of these, and no library effect beside them, leave the same trace in falls and contacts.
TUMBLE_LIBRARY = tuple(_BY_NAME[name] for name in ("contact.friction", "body.com_offset"))
TUMBLE_OUTSIDE = tuple(_BY_NAME[f"outside.{name}"] for name in ("friction_by_place", "friction_fades", "lift", "gusts"))
# What each twin is hidden as; whether it is one follows from the data.
TWINS = (
    ("world.gravity_magnitude", False),
    ("sensor.scale", False),
    ("sensor.clock_skew", False),
    ("world.gravity_tilt", True),
    ("world.constant_force", True),
    ("contact.friction", True),
)
PAIRS = (
    ("world.quadratic_drag", "body.com_offset", False),
    ("contact.friction", "world.gravity_tilt", True),
    ("world.linear_drag", "world.gravity_tilt", False),
)
