"""Stated friction and restitution: kept when possible, completed by the material class, refused when impossible."""

from __future__ import annotations

import numpy as np
import pytest

from assetkit.physics.source_contacts import contact_evidence
from assetkit.taxonomy.material_classes import contacts_of, materials
from schemas.diagnostics import Location
from schemas.evidence import default, inferred
from schemas.model import Mesh
from schemas.stated_physics import StatedContact
from tests.support.package_samples import box_mesh
from tests.support.present import present

WOOD = inferred("wood", "test", 0.4)
ROW = materials()["wood"]


def mesh(path: str, size=(0.1, 0.1, 0.1)) -> Mesh:
    body = box_mesh(size)
    return Mesh(path, body.points, body.triangles, source_path=path)


def stated(static=None, dynamic=None, restitution=None, path="/a", **changes) -> StatedContact:
    return StatedContact((path,), "grip", "test", Location(prim=path), static, dynamic, restitution, **changes)


def test_a_complete_statement_is_kept_as_it_is():
    touch = contact_evidence(WOOD, [stated(0.8, 0.6, 0.0, combine="minimum")], [mesh("/a")])
    (evidence,) = touch.contacts
    contact = evidence.value
    assert (contact.static_friction, contact.dynamic_friction, contact.restitution) == (0.8, 0.6, 0.0)
    assert (contact.combine, contact.counterpart, evidence.source) == ("minimum", "any", "declared")
    assert evidence.inputs == ("/a",)
    low, high = present(evidence.bounds)
    assert low.static_friction < 0.8 < high.static_friction


def test_what_is_not_stated_comes_from_the_class_in_its_ratio():
    (evidence,) = contact_evidence(WOOD, [stated(static=0.8)], [mesh("/a")]).contacts
    assert evidence.value.dynamic_friction == pytest.approx(0.8 * ROW.dynamic_friction / ROW.static_friction)
    assert evidence.value.restitution == ROW.restitution
    assert "dynamic_friction, restitution of material class wood" in evidence.method
    (evidence,) = contact_evidence(WOOD, [stated(dynamic=0.3)], [mesh("/a")]).contacts
    assert evidence.value.static_friction == pytest.approx(0.3 * ROW.static_friction / ROW.dynamic_friction)
    assert evidence.confidence < 0.5


def test_the_material_with_most_of_the_area_stands_for_the_body():
    contacts = [stated(0.2, 0.1, 0.5, "/a"), stated(0.9, 0.8, 0.1, "/b")]
    touch = contact_evidence(default("unknown"), contacts, [mesh("/a"), mesh("/b", (0.3, 0.3, 0.3))])
    assert touch.contacts[0].value.static_friction == 0.9


@pytest.mark.parametrize(
    "values",
    [(-0.1, None, None), (0.5, 0.6, None), (9.0, 0.5, None), (0.5, 0.4, 1.5), (np.nan, None, None), (0.5, 0.4, np.inf)],
)
def test_an_impossible_statement_is_refused_with_value_and_bound(values):
    touch = contact_evidence(WOOD, [stated(*values)], [mesh("/a")])
    assert touch.contacts == contacts_of(WOOD)
    (note,) = touch.diagnostics
    assert note.code == "asset/source-friction-implausible"
    assert note.value is not None
    assert note.bound is not None
    assert [r.name for r in touch.repairs] == ["implausible_friction"]


@pytest.mark.parametrize("contacts", [[], [stated()], [stated(0.5, 0.4, 0.1, "/elsewhere")]])
def test_silence_leaves_the_class(contacts):
    assert contact_evidence(WOOD, contacts, [mesh("/a")]).contacts == contacts_of(WOOD)
