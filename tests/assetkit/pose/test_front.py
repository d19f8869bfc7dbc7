"""The front of an object: away from the hand, turning with the object, unknown without evidence."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from assetkit.parts.find import find_parts
from assetkit.parts.proposals import join_meshes
from assetkit.pose.front import FULL, Front, front_of, heading_symmetry
from benchmarks.assets.made_things import Thing, things
from geom.features.cavities import find_cavities
from schemas.evidence import declared, default
from schemas.model import Mesh
from schemas.physics import Solid

# What sticks out towards +x of a made thing is its handle, so -x is the front.
HELD = [t for t in things(seed=3, draws=1) if t.name in {"mug", "square mug", "pan"}]


def asked(thing: Thing, yaw_rad: float, scale: float = 1.0) -> Front:
    points = scale * thing.points @ Rotation.from_euler("z", yaw_rad).as_matrix().T
    cavities = find_cavities(Solid(points, thing.triangles, "closed"))
    mesh, category = Mesh("m", points, thing.triangles), declared(thing.category, "test")
    parts = find_parts({"m": mesh}, (), category, cavities=cavities).parts
    return front_of({"m": mesh}, category, parts, cavities)


@pytest.mark.parametrize("thing", HELD, ids=lambda t: t.name)
@pytest.mark.parametrize("yaw_rad", [0.0, np.pi / 2.0, 0.6])
def test_the_front_is_away_from_the_hand_and_turns_with_the_thing(thing: Thing, yaw_rad: float) -> None:
    """At right angles exactly, in between to a few degrees."""
    found = asked(thing, yaw_rad, 10.0)
    true = np.array([-np.cos(yaw_rad), -np.sin(yaw_rad), 0.0])
    assert found.symmetry.value == 1
    assert found.direction.confidence > 0.5
    assert np.dot(found.direction.value, true) > np.cos(np.radians(1e-6 if yaw_rad != 0.6 else 10.0))


@pytest.mark.parametrize(("name", "symmetry"), [("tumbler called mug", FULL), ("basket", 2)])
def test_what_looks_the_same_from_behind_has_no_front(name: str, symmetry: int) -> None:
    """A mug without a handle is round."""
    thing = next(t for t in things(seed=3, draws=1) if t.name == name)
    found = asked(thing, 0.3)
    assert (found.symmetry.value, found.direction.confidence) == (symmetry, 0.0)


def test_nothing_is_said_of_what_nobody_knows() -> None:
    """A handle on something may be on any side of it."""
    mesh = Mesh("m", HELD[0].points, HELD[0].triangles)
    assert front_of({"m": mesh}, default("unknown"), (), ()).direction.confidence == 0.0


@pytest.mark.parametrize(("sections", "symmetry"), [(3, 3), (4, 4), (6, 6), (64, FULL)])
def test_prisms_look_the_same_in_as_many_headings_as_they_have_sides(sections: int, symmetry: int) -> None:
    """A round object looks the same in every heading."""
    prism = trimesh.creation.cylinder(0.05, 0.1, sections=sections)
    mesh = Mesh("m", np.asarray(prism.vertices), np.asarray(prism.faces, dtype=np.int32))
    assert heading_symmetry(join_meshes([mesh])) == symmetry


def test_a_thin_spout_tells_the_headings_apart() -> None:
    """It is so little surface that the mean distance of the turned pot from itself stays below the slack."""
    pot = trimesh.creation.cylinder(0.06, 0.1, sections=96)
    spout = trimesh.creation.cylinder(0.014, segment=[[0.05, 0.0, 0.0], [0.1, 0.0, 0.03]], sections=12)
    shape = trimesh.boolean.union([pot, spout], engine="manifold")
    mesh = Mesh("m", np.asarray(shape.vertices), np.asarray(shape.faces, dtype=np.int32))
    assert heading_symmetry(join_meshes([mesh])) == 1


@pytest.mark.parametrize("yaw_rad", [0.0, 0.6])
def test_a_case_with_its_door_on_one_side_and_its_knob_on_the_other_looks_where_its_walls_do(yaw_rad: float) -> None:
    """A microwave: neither part is straight ahead of the middle, and both are on the front."""
    pieces = {"case": ((0.34, 0.48, 0.28), (0.0, 0.0, 0.0)), "door": ((0.02, 0.34, 0.26), (0.18, -0.06, 0.0))}
    pieces["knob"] = ((0.02, 0.04, 0.04), (0.18, 0.18, 0.0))
    R = Rotation.from_euler("z", yaw_rad).as_matrix()
    meshes: dict[str, Mesh] = {}
    for name, (extents, centre) in pieces.items():
        made = trimesh.creation.box(extents)
        points = (np.asarray(made.vertices, dtype=float) + centre) @ R.T
        meshes[name] = Mesh(name, points, np.asarray(made.faces, dtype=np.int32), source_path=f"/{name}")
    category = declared("microwave", "test")
    parts = find_parts(meshes, (), category, cavities=()).parts
    assert {"door", "knob"} <= {p.value.label.value for p in parts}
    found = front_of(meshes, category, parts, ())
    np.testing.assert_allclose(found.direction.value, R @ [1.0, 0.0, 0.0], atol=1e-6)
    assert found.direction.confidence > 0.5
