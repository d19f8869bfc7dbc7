"""What is reported as repaired: true defects and nothing else; and the corpus that says so."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.geometry.edits import EDITS
from assetkit.geometry.repair import repair_geometry
from assetkit.readers.by_format import MESH_FILES, READERS
from assetkit.sources.source_file import SourceFile
from geom.solid.solidify import solidify
from schemas.codes import CODES
from tests.conftest import SHARED
from tests.support.peers import needs_blender
from tests.support.sample_surfaces import ball, box, cylinder, inside_out, lidless, mesh_of, together, without

ASSETS = SHARED / "assets"
GEOMETRY_REPAIRS = {
    *("degenerate_faces", "flip_winding", "non_manifold_vertex", "non_manifold_edge", "duplicate_shell"),
    *("hole_fill", "self_intersection", "open_shell_keep_cavity"),
}


def repairs_of(*surfaces) -> list[str]:
    return [r.name for r in repair_geometry([mesh_of(*s, name=f"m{i}") for i, s in enumerate(surfaces)]).repairs]


def with_extra_faces(surface):
    points, triangles = surface
    extra = [*([[i, i, i + 1]] for i in range(6)), *(triangles[[i]] for i in range(4))]
    return points, np.vstack([triangles, *extra])


def turned(surface, share: float = 0.3):
    points, triangles = surface
    flip = np.random.default_rng(0).random(len(triangles)) < share
    return points, np.where(flip[:, None], triangles[:, [0, 2, 1]], triangles)


def finned(surface):
    points, triangles = surface
    fin = [[triangles[0, 0], triangles[0, 1], len(points)]]
    return np.vstack([points, points[triangles[0, 0]] * 1.2]), np.vstack([triangles, fin])


BROKEN = {
    "degenerate_faces": with_extra_faces(ball(subdivisions=1)),
    "flip_winding": turned(ball()),
    "non_manifold_edge": finned(ball()),
    "non_manifold_vertex": together(box(at=(0.5, 0.5, 0.5)), box(at=(-0.5, -0.5, -0.5))),
    "duplicate_shell": together(ball(), ball()),
    "hole_fill": (ball()[0], ball()[1][1:]),
    "self_intersection": together(box(), box(at=(0.5, 0.2, 0.1))),
    "open_shell_keep_cavity": lidless(box()),
}


@pytest.mark.parametrize("name", BROKEN)
def test_each_defect_gives_its_repair_and_no_other(name: str) -> None:
    assert repairs_of(BROKEN[name]) == [name]


@pytest.mark.parametrize("name", sorted(set(BROKEN) - {"open_shell_keep_cavity", "self_intersection"}))
def test_a_mended_mesh_needs_no_second_repair(name: str) -> None:
    once = repair_geometry([mesh_of(*BROKEN[name])])
    again = repair_geometry(once.meshes)
    assert again.repairs == ()
    assert once.reobserved.watertight
    assert not once.reobserved.inverted


def test_an_inside_out_solid_is_turned() -> None:
    result = repair_geometry([mesh_of(*inside_out(ball()))])
    assert [r.name for r in result.repairs] == ["flip_winding"]
    assert (result.observed[-1].inverted, result.reobserved.inverted) == (True, False)


def test_a_solid_drawn_from_both_sides_is_reduced_to_its_outside() -> None:
    result = repair_geometry([mesh_of(*together(inside_out(ball()), ball()))])
    (repair,) = result.repairs
    assert repair.name == "duplicate_shell"
    edges = 3 * len(ball()[1]) // 2
    assert (repair.before["back_faces"], repair.before["non_manifold_edges"]) == (len(ball()[1]), edges)
    assert (repair.after["back_faces"], repair.after["non_manifold_edges"]) == (0, 0)
    assert result.reobserved.watertight
    assert not result.reobserved.inverted
    assert result.reobserved.non_manifold_edges == 0


CARD = (np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
BY_DESIGN = {
    "solid": [box()],
    "hollow ball": [together(ball(), inside_out(ball(0.5)))],
    "card": [CARD],
    "double-sided card": [together(CARD, inside_out(CARD))],
    "double-sided over two meshes": [ball(), inside_out(ball())],
    "parts in contact": [together(box(), box(at=(1, 0, 0)), box(at=(0, 0, 1)))],
    "legs at the corners of a seat": [
        together(box((2, 2, 0.2), at=(0, 0, 0.1)), box((0.2, 0.2, 1), at=(0.9, 0.9, -0.5)))
    ],
    "meshes that penetrate": [box(), box(at=(0.5, 0.2, 0.1))],
    "six sides": [without(box(), lambda _, n, k=k: n @ k < 0.5) for k in np.vstack([np.eye(3), -np.eye(3)])],
    "eyes in their sockets": [
        without(ball(), lambda c, _: c[2] > 0.9),
        without(ball(0.45, at=(0, 0, 0.8)), lambda c, _: c[2] < 0.6),
    ],
    "open boards": [without(box((1, 0.1, 0.03), at=(0, 0, z)), lambda _, n: n[0] > 0.99) for z in (0.0, 0.2, 0.4)],
    "bottle under its cap": [lidless(cylinder(0.5, 2.0)), cylinder(0.52, 0.4)],
    "one stray sliver in a dense mesh": [(ball(subdivisions=4)[0], np.vstack([ball(subdivisions=4)[1], [[0, 0, 1]]]))],
}


@pytest.mark.parametrize("name", BY_DESIGN)
def test_what_artists_do_by_design_is_not_repaired(name: str) -> None:
    assert repairs_of(*BY_DESIGN[name]) == []


def test_every_repair_has_a_known_code_and_figures_before_and_after() -> None:
    for surface in BROKEN.values():
        result = repair_geometry([mesh_of(*surface)])
        assert [d.code for d in result.diagnostics] == [r.code for r in result.repairs]
        for repair in result.repairs:
            assert repair.code in CODES
            assert repair.stage == "canonicalize"
            assert repair.before
            assert repair.before.keys() == repair.after.keys()
    assert {step.code for step in EDITS} <= CODES.keys()


def test_meshes_keep_number_order_names_and_materials() -> None:
    meshes = [
        replace(mesh_of(*s, name=n), material=i, source_path=f"/{n}")
        for i, (n, s) in enumerate({"a": BROKEN["hole_fill"], "b": box(at=(9, 0, 0)), "c": turned(ball())}.items())
    ]
    result = repair_geometry(meshes)
    assert [(m.name, m.material, m.source_path) for m in result.meshes] == [
        (m.name, m.material, m.source_path) for m in meshes
    ]
    assert [t.name for t in result.observed] == ["a", "b", "c", "merged"]
    assert result.reobserved.name == "merged"
    for mesh in result.meshes:
        assert mesh.normals is not None
        assert len(mesh.normals) == len(mesh.uvs[0]) == len(mesh.triangles)


def test_a_mesh_without_any_area_survives_beside_a_sound_one() -> None:
    line = mesh_of(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), [[0, 1, 2], [0, 0, 1]])
    empty = mesh_of(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32))
    result = repair_geometry([mesh_of(*box()), line, empty])
    assert len(result.meshes) == 3
    assert solidify(result.meshes)[1]["volume_m3"] == pytest.approx(1.0)


def test_the_same_meshes_give_the_same_result() -> None:
    for surface in BROKEN.values():
        first, second = (repair_geometry([mesh_of(*surface)]) for _ in range(2))
        assert first.repairs == second.repairs
        assert first.meshes[0].points.tobytes() == second.meshes[0].points.tobytes()
        assert first.meshes[0].triangles.tobytes() == second.meshes[0].triangles.tobytes()


SURFACES = {row.name for row in MESH_FILES}  # A description is many surfaces that move; each link is judged alone.


def corpus() -> list[dict[str, str]]:
    if not (ASSETS / "manifest.csv").is_file():
        return []
    with (ASSETS / "manifest.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["format"] in SURFACES and row["outcome"] != "reject"]
    # Small files of the kinds judged here; what they say about geometry is their reason.
    judged = [
        row
        for row in rows
        if int(row["measured_faces"] or 0) < 20_000
        and (not row["reason"] or row["truth_volume_m3"] or GEOMETRY_REPAIRS & set(row["reason"].split(";")))
    ]
    return sorted(judged, key=lambda row: row["id"])


@pytest.mark.shared
@pytest.mark.parametrize("row", corpus(), ids=lambda row: row["id"])
def test_corpus(row: dict[str, str]) -> None:
    if row["format"] == "blend":
        needs_blender()
    path = ASSETS / row["path"]
    model = READERS[row["format"]](SourceFile(path, path.parents[len(Path(row["path"]).parts) - 3])).value
    assert model is not None
    result = repair_geometry(model.meshes)
    names = {r.name for r in result.repairs}
    expected = GEOMETRY_REPAIRS & set(row["reason"].split(";"))
    assert expected <= names
    if not row["reason"]:
        assert names == set()
    if row["truth_volume_m3"]:
        unit = float(row["meters_per_unit"] or model.meters_per_unit.value)
        volume = float(solidify(result.meshes)[1]["volume_m3"]) * unit**3
        assert volume == pytest.approx(float(row["truth_volume_m3"]), rel=5e-3)
