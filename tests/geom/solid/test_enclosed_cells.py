"""Bodies of surfaces whose edges have more than two faces: volumes known, whatever the winding and the copies."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from manifold3d import Manifold, OpType

from geom.mesh.edges import edges_of
from geom.mesh.manifold_arrays import manifold_arrays, signed_volume
from geom.mesh.surface_distance import triangle_areas
from geom.mesh.weld import weld_points
from geom.solid.closed_bodies import as_manifold, sort_bodies
from geom.solid.enclosed_cells import enclosed_cells
from geom.solid.solidify import solidify
from geom.solid.thicken import thicken
from tests.support.sample_surfaces import box, inside_out, mesh_of, together

PANEL = (np.array([[1.0, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]), np.array([[0, 1, 2], [0, 2, 3]]))


def cells_of(*surfaces):
    return enclosed_cells(*weld_points(*together(*surfaces)))


def volumes_of(*surfaces) -> list[float]:
    points, triangles = weld_points(*together(*surfaces))
    return sorted(signed_volume(points, body) for body in enclosed_cells(points, triangles).bodies)


def moved(surface, at):
    return surface[0] + np.asarray(at, dtype=float), surface[1]


def two_rooms(*, wall_drawn: int):
    """A box of 2 x 1 x 1 in two halves, with the wall between them drawn 0, 1 or 2 times."""
    left, right = box(at=(0.5, 0.5, 0.5)), box(at=(1.5, 0.5, 0.5))
    points, triangles = weld_points(*together(left, right))
    on_wall = (np.abs(points[triangles][..., 0] - 1.0) < 1e-9).all(axis=1)
    faces = [*np.flatnonzero(~on_wall), *np.flatnonzero(on_wall)[: 2 * wall_drawn]]
    return points, triangles[np.sort(faces)]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("wall_drawn", [0, 1, 2])
def test_a_wall_between_two_cells_is_inside_one_body_however_it_is_wound(wall_drawn: int, seed: int) -> None:
    points, triangles = two_rooms(wall_drawn=wall_drawn)
    flips = np.random.default_rng(seed).random(len(triangles)) < (0.5 if seed else 0.0)
    cells = enclosed_cells(points, np.where(flips[:, None], triangles[:, [0, 2, 1]], triangles))
    (body,) = cells.bodies
    assert signed_volume(points, body) == pytest.approx(2.0)
    assert set(edges_of(body).uses) == {2}
    assert edges_of(body).net.any() == 0
    assert not cells.sheets.any()


def test_boxes_that_meet_in_an_edge_are_two_bodies() -> None:
    assert volumes_of(box(), box(at=(1, 1, 0))) == pytest.approx([1.0, 1.0])


def test_a_board_on_an_edge_is_a_sheet_and_a_board_inside_is_nothing() -> None:
    cells = cells_of(box(at=(0.5, 0.5, 0.5)), moved(PANEL, (0, 1, 0)))
    assert len(cells.bodies) == 1
    assert cells.sheets.tolist() == [False] * 12 + [True] * 2
    inner = (np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 0.5, 0.5]]), np.array([[0, 1, 2]]))
    cells = cells_of(box(at=(0.5, 0.5, 0.5)), inner)
    assert [len(body) for body in cells.bodies] == [12]
    assert not cells.sheets.any()


@pytest.mark.parametrize(("wound_into", "volume"), [(True, 27.0 - 1.0), (False, 27.0)])
def test_a_room_wound_inwards_is_a_cavity(wound_into: bool, volume: float) -> None:
    inner = box(at=(0.0, 0.0, 0.0))
    web = (
        np.array([[1.5, 1.5, 1.5], [1.5, 1.5, -1.5], [0.5, 0.5, 0.5], [0.5, 0.5, -0.5]]),
        np.array([[0, 1, 3], [0, 3, 2]]),
    )
    surfaces = box((3, 3, 3)), inside_out(inner) if wound_into else inner, web
    assert sum(volumes_of(*surfaces)) == pytest.approx(volume)


def test_a_doubled_sheet_encloses_nothing() -> None:
    other_diagonal = PANEL[0], np.array([[0, 3, 1], [1, 3, 2]])
    cells = cells_of(PANEL, other_diagonal, moved(PANEL, (0, 1, 0)))
    assert cells.bodies == ()
    assert cells.sheets.all()


def carcass():
    """Walls of 0.1 around two compartments of 0.9 x 1 x 0.9 that are open at y = 1 and 0: their skin, each face once.

    Neighbouring boards share the edges at which they meet, and the face between them is drawn.
    """
    grid = np.array([0.0, 0.1, 1.0, 1.1, 2.0, 2.1]), np.array([0.0, 1.0]), np.array([0.0, 0.1, 1.0, 1.1])
    boards = []
    for i, k in itertools.product(range(5), range(3)):
        if i % 2 == 0 or k % 2 == 0:
            low = np.array([grid[0][i], grid[1][0], grid[2][k]])
            high = np.array([grid[0][i + 1], grid[1][1], grid[2][k + 1]])
            boards.append(box(high - low, 0.5 * (low + high)))
    points, triangles = weld_points(*together(*boards))
    times_drawn: dict[tuple[float, ...], int] = {}
    faces: list[int] = []
    for face, corners in enumerate(points[triangles]):
        side = tuple(np.round([*corners.min(axis=0), *corners.max(axis=0)], 6))
        times_drawn[side] = times_drawn.get(side, 0) + 1
        if times_drawn[side] <= 2:
            faces.append(face)
    return points, triangles[faces]


def test_boards_that_share_edges_are_a_body_with_open_compartments() -> None:
    points, triangles = carcass()
    uses = edges_of(triangles).uses
    assert (uses % 2 == 1).any()  # No winding makes this surface closed.
    solid, figures = solidify([mesh_of(points, triangles)])
    assert (solid.kind, figures["method"]) == ("closed", "union")
    assert figures["volume_m3"] == pytest.approx(2.1 * 1.1 - 2 * 0.9 * 0.9)
    assert figures["open_area_share"] == 0.0


def test_no_face_of_a_crowded_surface_is_lost() -> None:
    folded = together(PANEL, (PANEL[0], np.array([[0, 3, 1], [1, 3, 2]])))
    meshes = [mesh_of(*carcass()), mesh_of(*moved(folded, (5, 0, 0)), name="folded")]
    bodies = sort_bodies(meshes)
    assert [v.kind for v in bodies.open_bodies] == ["sheet"]
    drawn = sum(float(triangle_areas(m.points[m.triangles]).sum()) for m in bodies.tidied)
    assert bodies.closed_area + bodies.open_area == pytest.approx(drawn)


def test_shells_that_cross_at_a_shared_edge_keep_what_their_winding_encloses() -> None:
    """Around the edge the faces of both boxes alternate, so that inside and outside see each other."""
    points, triangles = weld_points(*together(wedge(0.0, 120.0), wedge(60.0, 180.0)))
    assert set(edges_of(triangles).uses) == {2, 4}
    assert enclosed_cells(points, triangles).bodies == () or sum(volumes_of((points, triangles))) < 1.0
    _, figures = solidify([mesh_of(points, triangles)])
    assert (figures["method"], figures["components"]) == ("union", 1)


def wedge(start_deg: float, end_deg: float):
    """A prism of unit height over a triangle between two directions, one edge on the z axis."""
    corners = [(0.0, 0.0), *((float(np.cos(a)), float(np.sin(a))) for a in np.radians([start_deg, end_deg]))]
    low, high = ([(x, y, z) for x, y in corners] for z in (0.0, 1.0))
    sides = [(i, (i + 1) % 3) for i in range(3)]
    triangles = [(0, 2, 1), (3, 4, 5), *((i, j, 3 + j) for i, j in sides), *((i, 3 + j, 3 + i) for i, j in sides)]
    return np.array([*low, *high]), np.array(triangles)


def test_the_hidden_ends_of_a_board_wound_at_random_are_closed() -> None:
    bar, end = box((2.0, 0.1, 0.1)), box((0.2, 0.6, 0.6), at=(1.1, 0, 0))
    along = np.abs(bar[0][bar[1]][..., 0].sum(axis=1)) < 2.9
    tube = bar[1][along]
    tube = np.where((np.arange(len(tube)) % 3 == 0)[:, None], tube[:, ::-1], tube)
    other = moved(end, (-2.2, 0, 0))
    _, figures = solidify([mesh_of(*s, name=n) for n, s in (("bar", (bar[0], tube)), ("end", end), ("other", other))])
    assert figures["method"] == "union"
    assert figures["volume_m3"] == pytest.approx(2.0 * 0.01 + 2 * 0.2 * 0.36)


def test_a_union_read_back_keeps_its_volume() -> None:
    corners = [
        ((0, 3, 2), (1, 6, 3)),
        ((0, 3, 2), (3, 6, 3)),
        ((0, 0, 3), (2, 3, 6)),
        ((1, 3, 2), (2, 4, 5)),
        ((0, 0, 1), (3, 2, 4)),
    ]
    boxes = [Manifold.cube(np.subtract(high, low).astype(float)).translate(low) for low, high in corners]
    points, triangles = manifold_arrays(Manifold.batch_boolean(boxes, OpType.Add))
    assert signed_volume(points, triangles) == pytest.approx(43.0)
    assert as_manifold(points, triangles).volume() == pytest.approx(43.0)


def test_a_sheet_folded_onto_itself_becomes_a_wall() -> None:
    other_diagonal = PANEL[0], np.array([[0, 3, 1], [1, 3, 2]])
    points, triangles = thicken(*together(PANEL, other_diagonal), 0.02)
    assert signed_volume(points, triangles) == pytest.approx(0.02, rel=1e-6)


def test_a_sheet_whose_corners_and_centres_lie_on_bodies_is_still_seen() -> None:
    frame = [box((0.1, 1.2, 0.1), at=(1.0, 0.5, z)) for z in (-0.05, 1.05)]
    knobs = [box((0.1, 0.1, 0.1), at=(1.0, *centre)) for centre in PANEL[0][PANEL[1]][..., 1:].mean(axis=1)]
    solid, figures = solidify([mesh_of(*s, name=str(i)) for i, s in enumerate([*frame, *knobs, PANEL])])
    assert figures["method"] == "union_and_walls"
    assert solid.walls is not None
