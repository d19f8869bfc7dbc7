"""What a draft offers: parts carry what lies on them, and who has no grasp says why."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from assetkit.affordances.find import AffordanceResult, find_affordances
from assetkit.affordances.named_regions import named_regions, part_at
from assetkit.options import Options
from schemas.affordances import WHOLE, Grasp
from schemas.asset import Role
from schemas.evidence import Evidence, inferred, measured
from schemas.parts import Part
from schemas.physics import RigidBody
from sim.fake import FakeSimulator
from tests.laws.test_stated_physics_released import finished


def offered(folder: Path, edges_m: tuple[float, float, float], role: Role | None = None) -> AffordanceResult:
    file = folder / "part.obj"
    trimesh.creation.box(edges_m).export(file)
    draft, _, _ = finished(file, Options(units="m", role=role))
    assert draft.physics is not None
    body = RigidBody("part", draft.physics.shapes, draft.physics.mass, draft.physics.contact)
    return find_affordances(draft, body, (), (), FakeSimulator())


def test_a_block_is_grasped(tmp_path: Path):
    found = offered(tmp_path, (0.05, 0.06, 0.1))
    assert found.diagnostics == ()
    assert all(isinstance(e.value, Grasp) and e.value.part == WHOLE for e in found.affordances)


@pytest.mark.parametrize(
    ("edges_m", "role", "why"),
    [((0.5, 0.5, 0.5), None, "weighs"), ((0.1, 0.1, 0.1), None, "wide"), ((0.05, 0.06, 0.1), "fixture", "stays")],
)
def test_who_has_no_grasp_says_why(tmp_path: Path, edges_m: tuple[float, float, float], role, why: str):
    found = offered(tmp_path, edges_m, role)
    assert found.affordances == ()
    assert [d.code for d in found.diagnostics] == ["asset/no-grasp"]
    assert why in found.diagnostics[0].headline


def part(part_id: str, label: str, low_m, high_m) -> Evidence[Part]:
    named = inferred(label, "test", 0.8)
    return measured(
        Part(
            part_id=part_id, label=named, name=label, sources=("hierarchy",), faces=(), triangles=0, area_m2=0.0,
            low_m=low_m, high_m=high_m,
        ),
        "test",
    )  # fmt: skip


POT = [
    part("part_0", "body", (-0.1, -0.1, 0.0), (0.1, 0.1, 0.1)),
    part("part_1", "lid", (-0.1, -0.1, 0.1), (0.1, 0.1, 0.11)),
    part("part_2", "knob", (-0.01, -0.01, 0.11), (0.01, 0.01, 0.13)),
    part("part_3", "unlabelled", (-0.01, -0.01, 0.11), (0.01, 0.01, 0.12)),
]


def test_named_parts_offer_what_they_are_named_for():
    found = named_regions(POT, np.array([-0.1, -0.1, 0.0]), np.array([0.1, 0.1, 0.13]))
    assert [(e.value.part, e.value.kind, e.value.task) for e in found] == [
        ("part_1", "lid", "open"),
        ("part_2", "knob", "turn"),
    ]
    assert found[0].value.direction == (0.0, 0.0, 1.0)
    assert all(e.source == "inferred" and e.confidence < 0.8 for e in found)


def test_a_place_belongs_to_the_smallest_named_part_around_it():
    assert part_at(POT, [(0.0, 0.0, 0.115)]) == "part_2"
    assert part_at(POT, [(-0.1, 0.0, 0.05), (0.1, 0.0, 0.05)]) == "part_0"
    assert part_at(POT, [(0.0, 0.0, 0.5)]) == WHOLE
