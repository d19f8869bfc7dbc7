"""Light meshes keep what refers to them, and their charts neither overlap nor leave the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image, ImageDraw

from assetkit.retopo import remesh
from assetkit.retopo.remesh import remeshed
from geom.mesh.surface_distance import two_way_distance
from schemas.model import Mesh
from tests.assetkit.retopo.things import bumpy_sphere, checkered_cube

SIZE_PX = 512


@pytest.fixture(scope="module")
def pair() -> tuple[tuple[Mesh, ...], tuple[Mesh, ...]]:
    """A cube beside a sphere, and both with 800 triangles together."""
    (cube,), (ball,) = checkered_cube().meshes, bumpy_sphere(5).meshes
    heavy = replace(cube, link="arm"), replace(ball, points=ball.points * 0.05 + (0.2, 0.0, 0.0))
    light = remeshed(heavy, 800, SIZE_PX)
    assert not isinstance(light, str), light
    return heavy, light


def test_names_ids_links_and_materials_stay_and_faces_are_shared_out(pair: tuple[tuple[Mesh, ...], ...]) -> None:
    heavy, light = pair
    kept = [(m.name, m.id, m.link, m.material, len(m.uvs)) for m in light]
    assert kept == [(m.name, m.id, m.link, m.material, 1) for m in heavy]
    assert 600 < sum(len(mesh.triangles) for mesh in light) <= 864
    for before, after in zip(heavy, light, strict=True):
        away = two_way_distance(before.points, before.triangles, after.points, after.triangles)
        assert away.hausdorff < 0.02 * np.ptp(before.points, axis=0).max()


def test_no_two_triangles_share_a_texel_and_charts_keep_their_distance(pair: tuple[tuple[Mesh, ...], ...]) -> None:
    """Drawn by Pillow's own filling: the sum of the areas is that of what is covered."""
    uvs = np.concatenate([mesh.uvs[0] for mesh in pair[1]]).astype(np.float64)
    assert uvs.min() >= 0.0
    assert uvs.max() <= 1.0
    image = Image.new("1", (4 * SIZE_PX, 4 * SIZE_PX))
    pen = ImageDraw.Draw(image)
    for corners in uvs * 4 * SIZE_PX:
        pen.polygon([(x, y) for x, y in corners], fill=1)
    first, second = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    signed = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    covered = np.asarray(image).mean()
    assert np.abs(signed).sum() == pytest.approx(covered, rel=0.05)
    assert covered > 0.3


def test_the_same_meshes_give_the_same_bytes(pair: tuple[tuple[Mesh, ...], ...]) -> None:
    again = remeshed(pair[0], 800, SIZE_PX)
    assert not isinstance(again, str)
    for first, second in zip(pair[1], again, strict=True):
        assert first.points.tobytes() == second.points.tobytes()
        assert first.uvs[0].tobytes() == second.uvs[0].tobytes()


def test_a_library_that_ends_is_a_reason_and_no_exception(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remesh, "REMESH_CPU_S", 0)
    reason = remeshed(checkered_cube().meshes, 100, SIZE_PX)
    assert isinstance(reason, str)
    assert "remeshing" in reason
