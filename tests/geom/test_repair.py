"""Each edit mends its defect, keeps corner attributes, and leaves sound surfaces alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geom.mesh.components import components_of
from geom.mesh.edges import edges_of
from geom.mesh.topology import observe
from geom.mesh.weld import weld
from geom.repair.boundary_loops import classify_open_bodies
from geom.repair.faces import drop_backs_of_solids, drop_fins, drop_surplus_faces, true_degenerates
from geom.repair.holes import capped_body, fill_openings
from geom.repair.shells import drop_duplicate_shells, drop_fragments
from geom.repair.vertices import split_bow_ties, touching_points
from geom.repair.winding import orient
from schemas.model import Mesh
from tests.support.sample_surfaces import ball, box, cylinder, inside_out, lidless, mesh_of, together, without


def seen(mesh: Mesh):
    return observe(mesh.points, mesh.triangles, mesh.name)


def bodies_of(surface):
    points, triangles = surface
    edges = edges_of(triangles)
    return classify_open_bodies(points, triangles, edges, components_of(points, triangles, edges))


def assert_attributes_follow(mesh: Mesh) -> None:
    """The samples store positions as UV and colour; every corner must still carry its own."""
    corners = mesh.points[mesh.triangles]
    assert mesh.colors is not None
    assert np.allclose(mesh.uvs[0], corners[..., :2], atol=1e-5)
    assert np.allclose(mesh.colors[..., :3], corners, atol=1e-5)


def assert_normals_look_out(mesh: Mesh) -> None:
    corners = mesh.points[mesh.triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert mesh.normals is not None
    assert (np.einsum("ij,ikj->ik", flat, mesh.normals.astype(float)) > 0.0).all()


SOUND = {
    "box": box(),
    "ball": ball(),
    "hollow ball": together(ball(), inside_out(ball(0.4))),
    "two boxes": together(box(), box(at=(3, 0, 0))),
    "lidless box": lidless(box()),
}


@pytest.mark.parametrize("name", SOUND)
@pytest.mark.parametrize("edit", [drop_surplus_faces, drop_fins, drop_duplicate_shells, orient])
def test_sound_surfaces_stay_as_they_are(name: str, edit) -> None:
    mesh = mesh_of(*SOUND[name])
    edited, figures = edit(mesh)
    assert np.array_equal(edited.points[edited.triangles], mesh.points[mesh.triangles])
    assert not any(figures.values())


def test_surplus_faces_go_and_the_solid_is_closed_again() -> None:
    points, triangles = ball(subdivisions=1)
    extra = [[0, 0, 1], [5, 7, 5], triangles[3], triangles[9][[0, 2, 1]]]
    mended, figures = drop_surplus_faces(mesh_of(points, np.vstack([triangles, extra])))
    assert figures == {"degenerate_faces": 2, "duplicate_faces": 2}
    assert seen(mended).watertight
    assert len(mended.triangles) == len(triangles)
    assert_attributes_follow(mended)


def test_a_sliver_that_closes_a_t_junction_stays() -> None:
    points, triangles = box()
    a, b, c = triangles[0]
    middle = len(points)
    split = np.vstack([triangles[1:], [[a, middle, c], [middle, b, c], [a, b, middle]]])
    mesh = mesh_of(np.vstack([points, (points[a] + points[b]) / 2]), split)
    assert seen(mesh).degenerate_faces == 1
    mended, figures = drop_surplus_faces(mesh)
    assert figures["degenerate_faces"] == 0
    assert seen(mended).watertight


def test_back_faces_and_touching_walls_are_not_surplus() -> None:
    double_sided = together(lidless(box()), inside_out(lidless(box())))
    neighbours = together(box(), box(at=(1, 0, 0)))
    for surface in (double_sided, neighbours):
        mesh = weld(mesh_of(*surface))
        assert len(drop_surplus_faces(mesh)[0].triangles) == len(mesh.triangles)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("body", [ball(), box(), cylinder()], ids=["ball", "box", "cylinder"])
def test_a_body_drawn_from_both_sides_keeps_its_outside_in_whatever_order(body, seed: int) -> None:
    """Each face and its reverse, shuffled: what is left is the body itself, and its corners carry their own."""
    points, triangles = body
    both = np.random.default_rng(seed).permutation(np.vstack([triangles, triangles[:, [0, 2, 1]]]))
    mended, figures = drop_backs_of_solids(weld(mesh_of(points, both)))
    assert figures == {"back_faces": len(triangles)}
    assert seen(mended).non_manifold_edges == 0
    assert seen(mended).volume == pytest.approx(seen(mesh_of(points, triangles)).volume)
    assert_attributes_follow(mended)
    again, none = drop_backs_of_solids(mended)
    assert again is mended
    assert none == {"back_faces": 0}


def test_backs_go_from_the_drawn_body_only() -> None:
    doubled = together(ball(), inside_out(ball()))
    sheet = together(lidless(box(at=(5, 0, 0))), inside_out(lidless(box(at=(5, 0, 0)))))
    mended, figures = drop_backs_of_solids(weld(mesh_of(*together(sheet, doubled, box(at=(9, 0, 0))))))
    assert figures == {"back_faces": len(ball()[1])}
    assert len(mended.triangles) == len(sheet[1]) + len(ball()[1]) + len(box()[1])


@pytest.mark.parametrize(
    "surface",
    [
        together(lidless(box()), inside_out(lidless(box()))),
        together(box(), box(at=(1, 0, 0))),
        together(*(box(at=(x, y, z)) for x in range(3) for y in range(3) for z in range(3))),
        together(ball(), inside_out(ball(0.5))),
    ],
    ids=["sheet", "contact", "cells", "hollow"],
)
def test_sheets_cells_and_cavities_keep_both_their_sides(surface) -> None:
    mesh = weld(mesh_of(*surface))
    assert drop_backs_of_solids(mesh)[0] is mesh


def test_collapsed_quads_with_their_own_texture_coordinates_are_no_defect() -> None:
    points, triangles = box()
    mesh = mesh_of(points, np.vstack([triangles, [[0, 0, 1]]]))
    assert true_degenerates(mesh) == 1
    mesh.uvs[0][-1, 1] += 0.1
    assert true_degenerates(mesh) == 0


def test_copies_of_a_shell_are_dropped() -> None:
    for copies in (together(box(), box(), box()), together(box(), box(at=(1e-6, 0, 0)), box(at=(0, 1e-6, 0)))):
        mended, figures = drop_duplicate_shells(weld(mesh_of(*copies)))
        assert figures == {"shells": 2}
        assert seen(mended).volume == pytest.approx(1.0)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**16), share=st.floats(0.0, 1.0))
def test_any_faces_turned_come_back_outward_with_cavities_inward(seed: int, share: float) -> None:
    points, triangles = together(ball(subdivisions=1), inside_out(ball(0.4, 1)), box(at=(3, 0, 0)))
    turned = np.random.default_rng(seed).random(len(triangles)) < share
    outer = turned[:80].copy()
    turned[80:160] = outer  # The cavity keeps its relation to its shell.
    broken = np.where(turned[:, None], triangles[:, [0, 2, 1]], triangles)
    mended, _ = orient(mesh_of(points, broken))
    expected = observe(points, triangles, "").volume
    after = seen(mended)
    assert after.inconsistent_edges == 0
    assert not after.inverted
    if turned[:80].all() or not turned[:80].any():
        assert after.volume == pytest.approx(expected)
    assert_attributes_follow(mended)
    assert_normals_look_out(mended)


def test_an_all_inverted_hollow_ball_keeps_its_cavity() -> None:
    surface = together(ball(), inside_out(ball(0.4)))
    mended, _ = orient(mesh_of(*inside_out(surface)))
    assert seen(mended).volume == pytest.approx(observe(*surface, "").volume)


def test_open_sheets_keep_their_winding_and_an_inverted_body_with_a_hole_does_not() -> None:
    sheet = mesh_of(*inside_out(lidless(box())))
    assert orient(sheet)[1] == {"flipped_faces": 0}
    points, triangles = inside_out(ball())
    holed = mesh_of(points, triangles[1:])
    assert orient(holed)[1] == {"flipped_faces": len(triangles) - 1}


def test_fins_go_but_boards_that_meet_stay() -> None:
    points, triangles = ball(subdivisions=2)
    fin = [[triangles[0, 0], triangles[0, 1], len(points)]]
    mended, figures = drop_fins(
        mesh_of(np.vstack([points, points[triangles[0, 0]] * 1.1]), np.vstack([triangles, fin]))
    )
    assert figures == {"fin_faces": 1}
    assert seen(mended).watertight
    boards = mesh_of(
        np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1.0]]), [[0, 1, 2], [0, 1, 3], [0, 1, 4]]
    )
    assert drop_fins(boards)[1] == {"fin_faces": 0}


def test_two_solids_touching_in_a_point_are_parted() -> None:
    mesh = weld(mesh_of(*together(box(at=(0.5, 0.5, 0.5)), box(at=(-0.5, -0.5, -0.5)))))
    assert len(touching_points(mesh.points, mesh.triangles)) == 1
    split, figures = split_bow_ties(mesh, touching_points(mesh.points, mesh.triangles))
    assert figures == {"split_points": 1}
    assert np.allclose(split.points[split.triangles], mesh.points[mesh.triangles], atol=5e-5)
    assert seen(split).non_manifold_vertices == 0
    assert len(weld(split).points) == 16


def test_parts_that_share_a_corner_but_lie_against_each_other_are_by_design() -> None:
    seat, leg = box((2, 2, 0.2), at=(0, 0, 0.1)), box((0.2, 0.2, 1), at=(0.9, 0.9, -0.5))
    through = box((1, 1, 1), at=(0.5, 0.5, 0.5)), box((2, 2, 2), at=(1, 1, 1))
    for pair in ((seat, leg), through):
        mesh = weld(mesh_of(*together(*pair)))
        assert seen(mesh).non_manifold_vertices == 1
        assert len(touching_points(mesh.points, mesh.triangles)) == 0


def test_a_surface_of_patches_keeps_them_all() -> None:
    points, triangles = ball(subdivisions=4)
    corners = points[triangles]
    patches = (0.9 * corners + 0.1 * corners.mean(axis=1, keepdims=True)).reshape(-1, 3)
    plate = box((0.3, 0.3, 0.3), at=(3, 0, 0))
    mesh = mesh_of(*together((patches, np.arange(len(patches)).reshape(-1, 3)), plate))
    assert drop_fragments(mesh)[1] == {"fragments": 0}


def test_stray_fragments_go_and_small_closed_parts_stay() -> None:
    crumb = without(ball(0.004, 0, at=(1.2, 0, 0)), lambda c, _: c[2] > 0)
    screw = ball(0.004, 0, at=(-1.2, 0, 0))
    mended, figures = drop_fragments(mesh_of(*together(ball(), crumb, screw)))
    assert figures == {"fragments": 1}
    assert seen(mended).components == 2


CUP = without(cylinder(0.5, 1.2), lambda c, n: n[2] > 0.99)
OPENINGS = {
    "lidless box": (lidless(box()), "container"),
    "lidless low tray": (lidless(box((1, 0.7, 0.12))), "container"),
    "cup sheet": (CUP, "container"),
    "cylinder without bottom": (inside_out(lidless(inside_out(cylinder()))), "container"),
    "hemisphere bowl": (without(ball(), lambda c, _: c[2] > 0.0), "container"),
    "cube without a side": (without(box(), lambda _, n: n[0] > 0.99), "container"),
    "open tube": (without(cylinder(), lambda _, n: abs(n[2]) > 0.99), "container"),
    "vase with a narrow neck": (without(together(cylinder(0.2, 4.0)), lambda _, n: n[2] > 0.99), "container"),
    "card": ((np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])), "sheet"),
    "curved card": (without(ball(), lambda c, _: c[2] < 0.97), "sheet"),
    "ball without one face": ((ball()[0], ball()[1][1:]), "holes"),
    "ball with a small cap missing": (without(ball(), lambda c, _: c[2] > 0.94), "holes"),
    "box without one face": ((box()[0], box()[1][1:]), "holes"),
    "cylinder without one face of its lid": ((cylinder()[0], cylinder()[1][1:]), "holes"),
}


@pytest.mark.parametrize("name", OPENINGS)
def test_openings_are_told_apart(name: str) -> None:
    surface, kind = OPENINGS[name]
    assert [b.kind for b in bodies_of(surface)] == [kind]


@pytest.mark.parametrize("percent", [1, 5, 10, 20])
def test_a_ball_with_scattered_faces_missing_is_filled(percent: int) -> None:
    points, triangles = ball(subdivisions=4)
    rng = np.random.default_rng(percent)
    kept = np.sort(rng.permutation(len(triangles))[len(triangles) * percent // 100 :])
    mesh = mesh_of(points, triangles[kept])
    (body,) = [b for b in bodies_of((mesh.points, mesh.triangles)) if b.area > 1.0]
    assert body.kind == "holes"
    filled, figures, _ = fill_openings(mesh, body.openings)
    whole = seen(weld(filled))
    assert figures["holes"] == len(body.openings)
    assert seen(mesh).boundary_edges - sum(len(o.points) for o in body.openings) == whole.boundary_edges
    if whole.watertight:
        assert whole.volume == pytest.approx(observe(points, triangles, "").volume, rel=0.01)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**16), count=st.integers(1, 6))
def test_neighbouring_faces_missing_from_a_solid_are_filled_without_loss(seed: int, count: int) -> None:
    points, triangles = ball(subdivisions=3)
    rng = np.random.default_rng(seed)
    centre = points[triangles[rng.integers(len(triangles))]].mean(axis=0)
    near = np.argsort(np.linalg.norm(points[triangles].mean(axis=1) - centre, axis=1))
    mesh = mesh_of(points, np.delete(triangles, near[:count], axis=0))
    (body,) = bodies_of((mesh.points, mesh.triangles))
    filled, figures, _ = fill_openings(mesh, body.openings)
    after = seen(weld(filled))
    assert body.kind == "holes"
    assert after.watertight
    assert after.inconsistent_edges == after.non_manifold_edges == 0
    assert after.volume == pytest.approx(observe(points, triangles, "").volume, rel=5e-3)
    assert figures["filled_area"] > 0.0
    assert filled.normals is not None
    assert len(filled.normals) == len(filled.uvs[0]) == len(filled.triangles)
    assert_normals_look_out(filled)


def test_a_cap_takes_the_attributes_of_its_rim() -> None:
    points, triangles = box()
    mesh = mesh_of(points, triangles[1:])
    (body,) = bodies_of((mesh.points, mesh.triangles))
    filled, _, _ = fill_openings(mesh, body.openings)
    assert_attributes_follow(filled)


def test_each_of_several_open_bodies_is_capped_by_itself() -> None:
    """The faces of two boxes without a face take turns in the surface, and a loose card ends it."""
    points, triangles = together(box(), box((1, 2, 3), at=(5, 0, 0)), OPENINGS["card"][0])
    turns = np.arange(24).reshape(2, 12).T.reshape(-1)
    triangles = np.concatenate([triangles[turns][2:], triangles[24:]])
    *boxes, card = bodies_of((points, triangles))
    for body, volume in zip(boxes, (1.0, 6.0), strict=True):
        closed = observe(*capped_body(points, triangles, body), "")
        assert closed.watertight
        assert closed.volume == pytest.approx(volume)
    assert len(capped_body(points, triangles, card)[1]) == 4


def test_openings_do_not_depend_on_scale_or_place() -> None:
    for surface, kind in OPENINGS.values():
        points, triangles = surface
        assert [b.kind for b in bodies_of((points * 1e-3 + 50.0, triangles))] == [kind]
