"""Cutting, joining and trimming, each against a body whose best answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold, OpType
from scipy.spatial import ConvexHull

from geom.decomposition.decompose import convex_parts
from geom.decomposition.merge_hulls import merge_hulls
from geom.decomposition.plane_cuts import CutGoal, Piece, cut_apart, excess_after
from geom.decomposition.simplified_body import simplified, simplify_body
from geom.decomposition.trim_hulls import UNCERTAIN, VolumeBelow, trim_hulls
from geom.features.cavities import find_cavities
from geom.mesh.manifold_arrays import manifold_arrays
from geom.mesh.surface_distance import SignedDistance
from schemas.physics import Solid


def table() -> Manifold:
    top = Manifold.cube((1.0, 0.6, 0.04)).translate((0, 0, 0.7))
    corners = [(x, y) for x in (0.0, 0.95) for y in (0.0, 0.55)]
    return Manifold.batch_boolean(
        [top, *(Manifold.cube((0.05, 0.05, 0.7)).translate((x, y, 0)) for x, y in corners)],
        OpType.Add,
    )


def bowl(wall: float = 0.08) -> Manifold:
    whole = Manifold.sphere(1.0, 40) - Manifold.sphere(1.0 - wall, 40)
    return whole.trim_by_plane((0.0, 0.0, -1.0), 0.0)


def piece(body: Manifold) -> Piece:
    return Piece(body, body.hull())


def test_a_table_is_a_board_and_four_legs():
    parts = cut_apart([table()], CutGoal(slack=1e-3, most=40, violation=lambda _: 0.0))
    assert sorted(p.body.volume() for p in parts) == pytest.approx([0.00175] * 4 + [0.024], rel=1e-2)
    assert sum(p.excess for p in parts) <= 1e-3 * table().volume()


@pytest.mark.parametrize("normal", [(1, 0, 0), (0, 0, 1), (0.6, 0.0, 0.8), (0.36, 0.48, 0.8)])
@pytest.mark.parametrize("offset", [-0.35, -0.1, 0.02, 0.3])
@pytest.mark.parametrize("shape", ["table", "bowl", "pipe"])
def test_foreseen_excess_is_that_of_the_real_cut(shape, normal, offset):
    pipe = Manifold.cylinder(1.0, 0.3, 0.3, 40, center=True) - Manifold.cylinder(1.2, 0.25, 0.25, 40, center=True)
    body = {"table": table().translate((-0.5, -0.3, -0.4)), "bowl": bowl(), "pipe": pipe}[shape]
    foreseen = excess_after(piece(body), np.array(normal, dtype=float), offset)
    halves = body.split_by_plane(normal, offset)
    parts = [piece(part) for half in halves for part in half.decompose()]
    if not len(foreseen):
        assert len(parts) == 1
    else:
        assert foreseen.sum() == pytest.approx(sum(p.excess for p in parts), rel=0.01)
        assert len(foreseen) == len(parts)


def test_a_convex_body_is_left_whole():
    ball = Manifold.sphere(1.0, 48)
    assert len(cut_apart([ball], CutGoal(slack=0.03, most=80, violation=lambda _: 0.0))) == 1


def test_pieces_fill_the_body():
    parts = cut_apart([bowl()], CutGoal(slack=0.1, most=50, violation=lambda _: 0.0))
    assert sum(p.body.volume() for p in parts) == pytest.approx(bowl().volume(), rel=1e-4)


def test_what_is_unfit_is_cut_though_its_volume_is_small():
    fork = (
        Manifold.cube((1.0, 0.1, 0.1))
        + Manifold.cube((0.01, 0.1, 0.3))
        + Manifold.cube((0.01, 0.1, 0.3)).translate((0.99, 0, 0))
    )
    goal = CutGoal(slack=5.0, most=40, violation=lambda hull: max(0.0, hull.volume() - 0.015))
    assert len(cut_apart([fork], goal)) >= 3
    assert len(cut_apart([fork], CutGoal(slack=5.0, most=40, violation=lambda _: 0.0))) == 1


def block(x: float, y: float) -> Manifold:
    return Manifold.cube((1, 1, 1)).translate((x, y, 0))


def test_merging_joins_what_adds_no_volume_first():
    blocks = [block(0, 0), block(1, 0), block(2, 0), block(0, 5)]
    row, alone = sorted(merge_hulls(blocks, 2), key=lambda h: -h.volume())
    assert row.volume() == pytest.approx(3.0)
    assert alone.volume() == pytest.approx(1.0)
    assert len(merge_hulls(blocks, 1)) == 1
    apart = merge_hulls(blocks, 1, violation=lambda h: np.inf if h.bounding_box()[4] > 2 and h.volume() > 1.5 else 0.0)
    assert len(apart) == 2


def test_merging_goes_on_while_it_is_cheap_and_harmless():
    blocks = [block(k, 0) for k in range(6)]
    assert len(merge_hulls(blocks, 32)) == 6
    assert len(merge_hulls(blocks, 32, spare=1e-6)) == 1
    assert len(merge_hulls(blocks, 32, spare=1e-6, violation=lambda h: h.volume() / 2.5)) == 3


def test_a_fault_makes_a_pair_dearer():
    near, far = [block(0, 0), block(1.1, 0)], block(0, 1.2)
    assert sorted(h.volume() for h in merge_hulls([*near, far], 2)) == pytest.approx([1.0, 2.1])
    joined = merge_hulls([*near, far], 2, violation=lambda h: 10.0 if h.bounding_box()[3] > 1.5 else 0.0)
    assert sorted(h.volume() for h in joined) == pytest.approx([1.0, 2.2])


def test_trimming_makes_a_bent_plate_as_thin_as_it_is():
    ring = Manifold.cylinder(1.0, 1.0, 1.0, 96) - Manifold.cylinder(1.0, 0.97, 0.97, 96)
    quarter = ring.trim_by_plane((1, 0, 0), 0.7)
    (trimmed,) = trim_hulls([quarter.hull()], [quarter], SignedDistance(*manifold_arrays(quarter)), depth=0.4)
    assert quarter.hull().volume() > 5.0 * quarter.volume()
    assert quarter.volume() <= trimmed.volume() <= 1.05 * quarter.volume()
    # The slab between the edges stays: less than half a wall is taken from the inside.
    assert trimmed.bounding_box()[0] == pytest.approx(quarter.bounding_box()[0], abs=0.015)


@pytest.mark.parametrize("seed", range(5))
def test_volume_below_a_plane_is_that_of_the_cut_body(seed: int):
    """Bodies with corners and faces at the height of the plane too; far closer than what counts as certain."""
    rng = np.random.default_rng(seed)
    bodies = (Manifold.hull_points(rng.normal(size=(30, 3))), Manifold.cube((1.0, 2.0, 3.0)))
    for body, normal in zip(bodies, (np.array([0.6, 0.0, 0.8]), np.array([0.0, 0.0, 1.0])), strict=True):
        below = VolumeBelow(body, normal)
        heights = manifold_arrays(body)[0] @ normal
        for height in (*np.linspace(heights.min() - 0.1, heights.max() + 0.1, 23), *heights):
            cut = body.trim_by_plane((-normal[0], -normal[1], -normal[2]), -height)
            assert below(float(height)) == pytest.approx(cut.volume(), abs=1e-3 * UNCERTAIN * body.volume())
        assert below.top == heights.max()


def test_trimming_leaves_flat_faces_and_joints_alone():
    wedge = Manifold.hull_points(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [0, 1, 1.0]]))
    hollow = wedge - Manifold.cube((0.2, 0.8, 0.2)).translate((0.1, 0.1, 0.1))
    (kept,) = trim_hulls([wedge], [wedge ^ hollow], SignedDistance(*manifold_arrays(hollow)), depth=0.1)
    assert kept.volume() == pytest.approx(wedge.volume())
    plate = Manifold.cylinder(0.2, 1.0, 1.0, 64)
    half, rest = plate.split_by_plane((1, 0, 0), 0.0)
    inside = half ^ (plate - rest.scale((0.1, 0.1, 0.1)))
    (joined,) = trim_hulls([half], [inside], SignedDistance(*manifold_arrays(plate)), depth=0.1)
    assert joined.bounding_box()[0] == pytest.approx(half.bounding_box()[0])


def test_trimming_takes_emptiness_but_less_than_half_a_wall():
    tent = Manifold.cube((2.0, 1.0, 0.1)).rotate((0, 30, 0)) + Manifold.cube((2.0, 1.0, 0.1)).rotate((0, 150, 0))
    (trimmed,) = trim_hulls([tent.hull()], [tent], SignedDistance(*manifold_arrays(tent)), depth=0.5)
    assert trimmed.volume() < tent.hull().volume()
    assert trimmed.bounding_box()[5] == pytest.approx(tent.bounding_box()[5], abs=0.05)


def test_a_thin_bowl_keeps_its_volume_its_form_and_its_inside():
    points, triangles = manifold_arrays(bowl())
    solid = Solid(points, triangles.astype(np.int32), "closed")
    body = simplify_body(solid.points, solid.triangles)
    parts = convex_parts(body, body.simplified.decompose(), find_cavities(solid))
    assert len(parts) <= 32
    volumes = sum(float(ConvexHull(p).volume) for p in parts)
    assert 0.95 * bowl().volume() <= volumes <= 1.15 * bowl().volume()


def test_a_rack_of_many_thin_boards_needs_more_pieces_and_hulls():
    """Seven boards and six walls between each two: 43 convex parts."""
    boards = [Manifold.cube((1.0, 0.4, 0.01)).translate((0, 0, 0.15 * k)) for k in range(7)]
    walls = [Manifold.cube((0.01, 0.4, 0.91)).translate((x, 0, 0)) for x in np.linspace(0.0, 0.99, 6)]
    rack = Manifold.batch_boolean([*boards, *walls], OpType.Add)
    body = simplify_body(*manifold_arrays(rack))
    ratios = []
    for most, pieces in ((32, 80), (64, 400)):
        parts = convex_parts(body, body.simplified.decompose(), (), most, pieces)
        assert len(parts) <= most
        ratios.append(sum(float(ConvexHull(p).volume) for p in parts) / rack.volume())
    assert ratios[0] > 2.0
    assert ratios[1] < 1.15


def test_preflight_names_what_is_wrong():
    points, triangles = manifold_arrays(table())
    for broken, reason in (
        ((points * np.nan, triangles), "not finite"),
        ((points * 0.0, triangles), "no extent"),
        ((points, triangles[1:]), "closed manifold"),
        ((points, triangles[:, ::-1]), "closed manifold"),
        ((points, np.concatenate([triangles, [[0, 1, 10_000]]])), "does not exist"),
        ((points, triangles[:0]), "empty"),
    ):
        with pytest.raises(ValueError, match=reason):
            simplify_body(*broken)


def test_preflight_makes_a_dense_body_light_and_leaves_a_thin_wall_alone():
    ball = Manifold.sphere(1.0, 400)
    light = simplified(ball)
    assert light.num_tri() < 0.1 * ball.num_tri()
    assert light.volume() == pytest.approx(ball.volume(), rel=0.02)
    thin = bowl(wall=0.002)
    assert simplified(thin).volume() == pytest.approx(thin.volume(), rel=0.02)


def test_preflight_fills_sealed_cavities():
    hollow = Manifold.cube((1, 1, 1)) - Manifold.cube((0.8, 0.8, 0.8)).translate((0.1, 0.1, 0.1))
    body = simplify_body(*manifold_arrays(hollow))
    assert body.full.volume() == pytest.approx(8.0)  # half extent 1
