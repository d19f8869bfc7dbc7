"""The basket is open at the rim, also where the cut of its inside would end level with it but for rounding."""

from __future__ import annotations

import numpy as np
import pytest

from assetkit.generate.objects.coloured_basket import GENERATOR, ColouredBasket
from assetkit.generate.parameters import random_parameters
from geom.mesh.rays import Rays

CLOSED_BY_A_FILM = ColouredBasket(
    width_m=0.19759681220154934,
    depth_m=0.2840641841552637,
    height_m=0.2165289876647408,
    wall_m=0.004486301183801481,
    flare=0.20546985646389063,
)


@pytest.mark.parametrize("seed", [None, 0, 1, 2, 3, 4])
def test_nothing_closes_the_rim(seed: int | None) -> None:
    values = CLOSED_BY_A_FILM
    if seed is not None:
        values = random_parameters(ColouredBasket, np.random.default_rng(seed))
    (basket,) = GENERATOR.run(values).objects
    inside = basket.interiors[0]
    shape = basket.links[0].parts[0].shape
    starts = np.array([[x, y, inside.low_m[2] + 0.001] for x in (-0.01, 0.02) for y in (-0.03, 0.01)])
    assert np.isinf(Rays(*shape.surface).hit_distances(starts, np.array([0.0, 0.0, 1.0]))).all()
    assert shape.solid.volume() + inside.volume_m3 == pytest.approx(outer_m3(values), rel=1e-6)


def outer_m3(p: ColouredBasket) -> float:
    """Volume of the frustum between floor and rim."""
    low, high = p.depth_m * p.width_m, (p.depth_m + 2 * p.flare * p.height_m) * (p.width_m + 2 * p.flare * p.height_m)
    middle = (p.depth_m + p.flare * p.height_m) * (p.width_m + p.flare * p.height_m)
    return p.height_m / 6.0 * (low + 4.0 * middle + high)
