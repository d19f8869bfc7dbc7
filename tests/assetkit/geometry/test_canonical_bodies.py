"""Links are mended apart: those that touch or overlap stay two solids; the object's results are those of all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assetkit.geometry.canonical_bodies import WholeObject, joined, mend_bodies
from assetkit.geometry.physical_surface import physical_surface
from assetkit.options import Options
from schemas.model import Mesh
from tests.support.package_samples import box_mesh

BOX = (0.1, 0.1, 0.1)
OVERLAP_M = 0.02
MESHES = (
    box_mesh(BOX, "case", link="case"),
    box_mesh(BOX, "door", (BOX[0] - OVERLAP_M, 0.0, 0.0), link="door"),
    box_mesh(BOX, "foot", (0.0, 0.0, -2.0 * BOX[2]), link="case"),
)
VOLUME_M3 = float(np.prod(BOX))


def whole(meshes: tuple[Mesh, ...]) -> WholeObject:
    bodies = mend_bodies(meshes, 10_000)
    surfaces = [
        physical_surface(b.mended, b.light, np.zeros(3), options=Options(), materials=(), meters_per_unit=1.0)
        for b in bodies
    ]
    return joined(meshes, bodies, surfaces)


def test_overlapping_links_keep_their_volumes_and_meshes_their_order() -> None:
    moving = whole(MESHES)
    assert [m.name for m in moving.mended.meshes] == [m.name for m in MESHES]
    assert [m.name for m in moving.light.meshes] == [m.name for m in MESHES]
    assert moving.physical.volume_m3 == pytest.approx(3 * VOLUME_M3)
    corners = moving.physical.solid.points[moving.physical.solid.triangles]
    enclosed_m3 = np.linalg.det(corners).sum() / 6.0
    assert enclosed_m3 == pytest.approx(3 * VOLUME_M3 - OVERLAP_M * BOX[1] * BOX[2])  # the union at rest


def test_the_same_meshes_of_a_rigid_object_are_united() -> None:
    rigid = whole(tuple(replace(m, link="") for m in MESHES))
    assert rigid.physical.volume_m3 == pytest.approx(3 * VOLUME_M3 - OVERLAP_M * BOX[1] * BOX[2])


def test_a_body_has_the_meshes_of_its_link() -> None:
    bodies = mend_bodies(MESHES, 10_000)
    assert [(body.link, body.meshes) for body in bodies] == [("case", (0, 2)), ("door", (1,))]
