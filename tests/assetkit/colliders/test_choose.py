"""Which rung of the ladder stands for a body of many thin parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from manifold3d import Manifold, OpType

from assetkit.colliders.choose import CUTS_FINE, choose_colliders
from geom.mesh.manifold_arrays import manifold_arrays
from schemas.physics import Solid


def comb(tooth_height_m: float) -> Solid:
    """Forty teeth 2 mm wide on a board 1 m long: 41 convex parts."""
    board = Manifold.cube((1.0, 0.1, 0.01))
    tooth = Manifold.cube((0.002, 0.1, tooth_height_m))
    teeth = [tooth.translate((x, 0, 0)) for x in np.linspace(0.0, 0.998, 40)]
    points, triangles = manifold_arrays(Manifold.batch_boolean([board, *teeth], OpType.Add))
    return Solid(points, triangles.astype(np.int32), "closed")


def test_more_hulls_stand_for_what_all_rungs_before_are_far_off(tmp_path: Path):
    """32 hulls fill gaps between high teeth: three times the volume and more."""
    found = choose_colliders(comb(0.1), tmp_path, cavities=())
    assert [row.method for row in found.candidates[-4:]] == ["cuts", "cuts_even", "coacd", CUTS_FINE]
    assert [row.shapes for row in found.candidates[-4:]] == [32, 32, 32, 41]
    assert all((row.volume_ratio or 0.0) > 3.0 for row in found.candidates[-4:-1])
    assert found.method == CUTS_FINE
    assert found.candidates[-1].accepted
    assert not found.diagnostics


def test_what_is_little_off_keeps_few_hulls(tmp_path: Path):
    """Gaps between low teeth are a quarter of the volume: the best of the others stands in, and that is said."""
    found = choose_colliders(comb(0.02), tmp_path, cavities=())
    assert CUTS_FINE not in [row.method for row in found.candidates]
    assert len(found.shapes) == 32
    assert [d.code for d in found.diagnostics] == ["asset/collision-fallback"]
