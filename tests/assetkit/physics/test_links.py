"""Physics of links: each has its own shapes and mass, the whole is their sum, and overlapping links are filtered."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from assetkit.mass.parts import MassEvidenceInputs
from assetkit.physics.links import link_physics
from assetkit.stage import LinkSurface, Physics
from geom.convex.support_function import surface
from schemas.diagnostics import Location
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from schemas.model import Mesh
from schemas.physics import Solid
from schemas.stated_physics import StatedMass
from tests.support.package_samples import box_mesh
from tests.support.present import present

HINGE = MechanismJoint(
    "hinge", "revolute", "case", "door", np.zeros(3), np.array([0.0, 0.0, 1.0]), rest=0.2, limits=(0.0, 1.5)
)
STATED_KG = 0.3


def boxes(gap_m: float) -> tuple[Mesh, Mesh]:
    """A case and a door of 2 cm to the right of it, `gap_m` apart."""
    case = box_mesh((0.1, 0.1, 0.1), "case", link="case", source_path="/case")
    door = box_mesh((0.02, 0.1, 0.1), "door", (0.06 + gap_m, 0.0, 0.0), link="door", source_path="/door")
    return case, door


def physics_of(meshes: tuple[Mesh, Mesh], folder: Path, joint: MechanismJoint = HINGE) -> Physics:
    mechanism = Mechanism((MechanismLink("case", np.zeros(3)), MechanismLink("door", np.zeros(3))), (joint,))
    surfaces = [LinkSurface(m.link, Solid(m.points, m.triangles, "closed")) for m in meshes]
    door = StatedMass(("/door",), len(meshes[1].triangles), "test", Location(file="test"), STATED_KG)
    inputs = MassEvidenceInputs(meshes=meshes, as_read=meshes, masses=(door,))
    return present(link_physics(mechanism, surfaces, inputs, names=[], contacts=(), work_dir=folder).value)


def test_each_link_has_its_shapes_and_mass_and_the_whole_is_their_sum(tmp_path: Path) -> None:
    meshes = boxes(0.01)
    physics = physics_of(meshes, tmp_path)
    assert [(body.name, body.shapes) for body in physics.links] == [("case", (0,)), ("door", (1,))]
    for shape, mesh in zip(physics.shapes, meshes, strict=True):
        points = surface(shape)[0]
        assert np.stack([points.min(axis=0), points.max(axis=0)]) == pytest.approx(
            np.stack([mesh.points.min(axis=0), mesh.points.max(axis=0)]), abs=1e-4
        )
    case, door = (body.mass for body in physics.links)
    assert door.mass_kg == pytest.approx(STATED_KG)
    assert door.centre_of_mass_m == pytest.approx(meshes[1].points.mean(axis=0), abs=1e-4)
    assert physics.mass.mass_kg == physics.section.mass_kg.value == pytest.approx(case.mass_kg + STATED_KG)
    weighed = case.mass_kg * case.centre_of_mass_m + door.mass_kg * door.centre_of_mass_m
    assert physics.mass.centre_of_mass_m == pytest.approx(weighed / physics.mass.mass_kg)
    assert [(link.name, link.mass_kg.source) for link in physics.section.links] == [
        ("case", "default"),
        ("door", "declared"),
    ]


@pytest.mark.parametrize(("gap_m", "pairs"), [(0.001, ()), (0.0, ()), (-0.01, (("case", "door"),))])
def test_links_that_overlap_at_rest_are_filtered(
    gap_m: float, pairs: tuple[tuple[str, str], ...], tmp_path: Path
) -> None:
    assert physics_of(boxes(gap_m), tmp_path).filtered_pairs == pairs


def test_the_record_says_which_limits_the_source_does_not_state(tmp_path: Path) -> None:
    (stated,) = physics_of(boxes(0.01), tmp_path / "a").section.joints
    (guessed,) = physics_of(boxes(0.01), tmp_path / "b", replace(HINGE, limits_inferred=True)).section.joints
    assert (stated.source, guessed.source) == ("declared", "inferred")
    assert (stated.value["limits_rad"], stated.value["rest_rad"]) == ((0.0, 1.5), 0.2)
    assert not {"damping", "effort", "follows", "closes_loop"} & stated.value.keys()
