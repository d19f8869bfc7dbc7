"""Open sheets and their outside: against closed forms of what each side sees, and as laws of the repair."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from assetkit.geometry.repair import repair_geometry
from geom.repair.sheet_orientation import SkyVisibility, sheet_flips
from schemas.model import Mesh
from tests.support.sample_surfaces import ball, box, inside_out, lidless, mesh_of, together, without

ARC = np.linspace(0.0, np.pi / 2, 13)


def turned_profile(profile, sections: int = 32):
    surface = trimesh.creation.revolve(np.array(profile, dtype=float), sections=sections)
    return np.array(surface.vertices), np.array(surface.faces, dtype=np.int32)


def car_body():
    """A crate, open below, with wheel arches."""
    fine = trimesh.Trimesh(*without(box((4.0, 1.8, 1.4)), lambda c, _: c[2] < -0.69)).subdivide().subdivide()
    surface = np.array(fine.vertices), np.array(fine.faces, dtype=np.int32)
    return without(surface, lambda c, n: abs(n[1]) > 0.9 and c[2] < -0.4)


# Each wound as an artist would, with its outside as the front.
VESSELS = {
    "cup": turned_profile([[0, 0], [0.04, 0], [0.04, 0.1]]),
    "open box": lidless(box((0.2, 0.14, 0.1))),
    "bowl": turned_profile([[1.2 * np.sin(t), -np.cos(t)] for t in ARC]),
    "half ball": turned_profile([[np.sin(t), -np.cos(t)] for t in ARC]),
    "lampshade": turned_profile([[0.05, 0.0], [0.1, 0.15]]),
    "vase": turned_profile([[0, 0], [0.05, 0.0], [0.08, 0.1], [0.03, 0.2], [0.04, 0.25]]),
    "car body": car_body(),
}


def posed(surface, seed: int, scale: float = 1.0):
    points, triangles = surface
    return scale * Rotation.random(rng=np.random.default_rng(seed)).apply(points) + scale * 3.0, triangles


def oriented(mesh: Mesh) -> set[tuple[int, ...]]:
    """Faces with their winding, whichever corner is named first."""
    return {tuple(np.roll(t, -int(np.argmin(t))).tolist()) for t in mesh.triangles}


def flips_of(*surfaces) -> list[np.ndarray]:
    """Per surface which of its faces turn, each being a mesh of its own."""
    points, triangles = together(*surfaces)
    owner = np.repeat(np.arange(len(surfaces)), [len(t) for _, t in surfaces])
    flips = sheet_flips(points, triangles, owner).flips
    return [flips[owner == i] for i in range(len(surfaces))]


@pytest.mark.parametrize("name", VESSELS)
def test_a_vessel_turned_inside_out_is_released_as_if_it_were_not(name: str) -> None:
    for seed, scale in enumerate((1.0, 1e-3, 1e3)):
        surface = posed(VESSELS[name], seed, scale)
        right, wrong = mesh_of(*surface), mesh_of(*inside_out(surface))
        kept, mended = (repair_geometry([mesh]) for mesh in (right, wrong))
        assert "flip_winding" not in [r.name for r in kept.repairs]
        assert [r.name for r in mended.repairs if r.name == "flip_winding"] == ["flip_winding"]
        assert oriented(mended.meshes[0]) == oriented(kept.meshes[0])
        assert float(mended.repairs[0].before["largest_inner_side_share"]) < 0.4


def test_what_each_side_sees_has_a_closed_form() -> None:
    """The inside of a vessel sees as much as its mouth has of its own area; the outside of a convex one sees it all."""
    for name, mouth in (("cup", 0.04**2), ("half ball", 1.0)):
        points, triangles = VESSELS[name]
        area = trimesh.Trimesh(points, triangles, process=False).area
        sides = SkyVisibility(points, triangles).of_sheet(triangles)
        disc = 0.5 * 32 * np.sin(2 * np.pi / 32) * mouth
        assert sides.front == pytest.approx(1.0, abs=2e-3)
        assert sides.back == pytest.approx(disc / area, abs=0.02)


def test_faces_turned_here_and_there_come_back() -> None:
    points, triangles = VESSELS["cup"]
    some = np.random.default_rng(0).random(len(triangles)) < 0.3
    for surface in ((points, triangles), inside_out((points, triangles))):
        mixed = np.where(some[:, None], surface[1][:, [0, 2, 1]], surface[1])
        mended = repair_geometry([mesh_of(points, mixed)]).meshes[0]
        assert oriented(mended) == oriented(mesh_of(points, triangles))


def test_sheets_of_one_scene_are_judged_one_by_one() -> None:
    row = [(p + np.array([3.0 * i, 0.0, 0.0]), t) for i, (p, t) in enumerate(posed(v, 7) for v in VESSELS.values())]
    mixed = [inside_out(s) if i % 2 else s for i, s in enumerate(row)]
    assert [flips.mean() for flips in flips_of(*mixed)] == [i % 2 for i in range(len(row))]


def test_a_vessel_of_two_meshes_that_share_a_seam_is_one_sheet() -> None:
    wall, floor = (without(VESSELS["cup"], lambda c, _, low=low: (c[2] < 1e-9) == low) for low in (True, False))
    assert all(flips.all() for flips in flips_of(inside_out(wall), inside_out(floor)))
    assert not any(flips.any() for flips in flips_of(wall, floor))


CARD = (np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
UNDECIDED = {
    "card": [CARD],
    "two walls at a right angle": [without(box(), lambda _, n: n[0] < 0.9 and n[2] < 0.9)],
    "dish": [turned_profile([[np.sin(t), -np.cos(t)] for t in ARC[:7]])],
    "ring": [turned_profile([[0.05, 0.0], [0.05, 0.02]])],
    "card on a board": [(CARD[0] + [0.0, 0.0, 0.51], inside_out(CARD)[1]), box((3.0, 3.0, 1.0))],
    "cup drawn from both sides": [VESSELS["cup"], inside_out(VESSELS["cup"])],
    "lining of a double wall": [ball(), inside_out(lidless(box((0.3, 0.3, 0.3))))],
}


@pytest.mark.parametrize("name", UNDECIDED)
def test_what_has_no_clear_outside_keeps_its_winding(name: str) -> None:
    for surfaces in (UNDECIDED[name], [inside_out(s) for s in UNDECIDED[name]]):
        assert not any(flips.any() for flips in flips_of(*surfaces))


def test_a_moebius_strip_has_no_side_to_turn() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 41)[:-1]
    rims = [
        np.stack([np.cos(turn) * r, np.sin(turn) * r, s * np.sin(turn / 2)])
        for s in (-0.3, 0.3)
        for r in (1 + s * np.cos(turn / 2),)
    ]
    a, b = np.arange(40), np.arange(40) + 40
    next_a, next_b = np.r_[a[1:], b[0]], np.r_[b[1:], a[0]]
    triangles = np.concatenate([np.stack([a, next_a, b], axis=1), np.stack([b, next_a, next_b], axis=1)])
    assert not flips_of((np.concatenate(rims, axis=1).T, triangles))[0].any()
