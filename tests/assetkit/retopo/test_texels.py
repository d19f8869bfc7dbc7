"""Texels of an atlas show the place of the mesh that renderers read there; charts go on beyond their edges."""

from __future__ import annotations

import numpy as np
import pytest

from assetkit.retopo.texels import atlas_texels, dilated
from schemas.model import Mesh

SIZE_PX = 64


def charted(*corners: list[list[float]]) -> Mesh:
    uvs = np.array(corners, dtype=np.float32)
    points = np.concatenate([uvs.reshape(-1, 2), np.zeros((3 * len(uvs), 1))], axis=1).astype(np.float64)
    return Mesh("m", points, np.arange(3 * len(uvs), dtype=np.int32).reshape(-1, 3), uvs=(uvs,))


LEFT = charted([[0.1, 0.1], [0.4, 0.1], [0.1, 0.9]])
RIGHT = charted([[0.6, 0.2], [0.9, 0.2], [0.9, 0.8]], [[0.6, 0.2], [0.9, 0.8], [0.6, 0.8]])


def test_weights_of_a_texel_give_its_centre() -> None:
    for mesh, texels in zip((LEFT, RIGHT), atlas_texels([LEFT, RIGHT], SIZE_PX, rim=False), strict=True):
        uvs = np.einsum("kc,kcx->kx", texels.weights, mesh.uvs[0][texels.faces].astype(np.float64))
        centres = np.stack([texels.columns + 0.5, texels.rows + 0.5], axis=1) / SIZE_PX
        np.testing.assert_allclose(uvs, centres, atol=1e-5)


def test_as_many_texels_as_the_area_of_the_charts_and_no_texel_twice() -> None:
    left, right = atlas_texels([LEFT, RIGHT], 512, rim=False)
    assert len(left.rows) == pytest.approx(0.5 * 0.3 * 0.8 * 512**2, rel=0.01)
    assert len(right.rows) == pytest.approx(0.3 * 0.6 * 512**2, rel=0.01)
    taken = {(*pair,) for each in (left, right) for pair in zip(each.rows.tolist(), each.columns.tolist(), strict=True)}
    assert len(taken) == len(left.rows) + len(right.rows)


def test_the_rim_holds_every_texel_that_bilinear_filtering_reads_inside_of_a_chart() -> None:
    (texels,) = atlas_texels([LEFT], SIZE_PX)
    shown = np.zeros((SIZE_PX, SIZE_PX), dtype=bool)
    shown[texels.rows, texels.columns] = True
    weights = np.random.default_rng(0).dirichlet((0.3, 0.3, 0.3), size=2000)
    column, row = np.floor((weights @ LEFT.uvs[0][0].astype(np.float64)) * SIZE_PX - 0.5).astype(int).T
    read = [shown[row + j, column + i] for i in (0, 1) for j in (0, 1)]
    assert np.mean(read) > 0.999
    assert (texels.weights > -1e-6).all()


def test_dilation_takes_the_nearest_value_within_reach_and_the_mean_beyond() -> None:
    values = np.zeros((9, 9, 1), dtype=np.float32)
    shown = np.zeros((9, 9), dtype=bool)
    values[0, 0], values[8, 8] = 4.0, 2.0
    shown[0, 0] = shown[8, 8] = True
    full = dilated(values, shown, 2)[..., 0]
    assert (full[0, 2], full[8, 6], full[0, 0], full[4, 4]) == (4.0, 2.0, 4.0, 3.0)
