"""Parts: which triangles they hold, what they are called, and when they have no name."""

from __future__ import annotations

from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
import trimesh
from hypothesis import given
from pxr import Sdf, Usd, UsdGeom
from scipy.spatial.transform import Rotation

from assetkit.parts.find import find_parts
from assetkit.parts.labels import label_in_name
from benchmarks.assets.made_things import Thing, things
from geom.features.cavities import find_cavities
from schemas.appearance.material import Material
from schemas.evidence import declared, default
from schemas.model import Mesh, Model
from schemas.parts import part_faces
from schemas.physics import Solid
from tests.support.bad_inputs.assets import joined
from usdio.write.materials.mesh_materials import materials_per_mesh
from usdio.write.meshes import author_meshes

LONG = {
    "spoon",
    "fork",
    "knife",
    "spatula",
    "ladle",
    "hammer",
    "screwdriver",
    "bottle with cap",
    "wine bottle",
    "wine glass",
}
LIMBED = [thing for thing in things(seed=7, draws=1) if thing.name in {"square mug", "oblong jug", "basket"}]
MADE = [thing for thing in things(seed=7, draws=1) if thing.name in LONG]


@given(st.sets(st.integers(0, 200)))
def test_triangles_come_back_from_their_text(chosen: set[int]) -> None:
    """Any set of triangles is the same after it was written down."""
    faces = part_faces("cup", sorted(chosen, reverse=True))
    assert faces.indices.tolist() == sorted(chosen)


def test_runs_are_written_short() -> None:
    """A person can read which triangles a part has."""
    assert part_faces("cup", np.array([0, 1, 2, 7, 9, 10])).ranges == "0-2 7 9-10"


def mug(handle_m: float = 0.04) -> trimesh.Trimesh:
    """A solid cylinder with a bow on its +y side."""
    body = trimesh.creation.cylinder(0.04, 0.1, sections=64).apply_translation((0.0, 0.0, 0.05))
    bow = trimesh.creation.torus(handle_m - 0.008, 0.005, major_sections=48, minor_sections=12)
    bow.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2.0, (0.0, 1.0, 0.0)))
    return joined(body, bow.apply_translation((0.0, 0.05, 0.05)))


def chair() -> trimesh.Trimesh:
    """Four legs, a seat and a back."""

    def box(size: tuple[float, ...], at: tuple[float, ...]) -> trimesh.Trimesh:
        return trimesh.creation.box(size).apply_translation(at)

    legs = [box((0.04, 0.04, 0.42), (x, y, 0.21)) for x in (-0.18, 0.18) for y in (-0.18, 0.18)]
    seat, back = box((0.42, 0.42, 0.04), (0.0, 0.0, 0.441)), box((0.04, 0.42, 0.4), (-0.19, 0.0, 0.6615))
    return joined(*legs, seat, back)


def labels(shape: trimesh.Trimesh, category: str) -> list[str]:
    """What is found on a shape of a stated category, without any name."""
    mesh = Mesh("m", np.asarray(shape.vertices), np.asarray(shape.faces, dtype=np.int32))
    return sorted(p.value.label.value for p in find_parts({"m": mesh}, (), declared(category, "test")).parts)


def test_a_bow_on_a_mug_is_its_handle() -> None:
    """The rest is the body."""
    assert labels(mug(), "mug") == ["body", "handle"]


@pytest.mark.parametrize("scale", [0.001, 1.0, 1000.0])
@pytest.mark.parametrize("yaw", [0.0, 0.7, 2.0])
def test_labels_do_not_depend_on_size_or_heading(scale: float, yaw: float) -> None:
    """Nothing in the rules is a length or a direction in the ground plane."""
    turned = mug().apply_transform(trimesh.transformations.rotation_matrix(yaw, (0.0, 0.0, 1.0))).apply_scale(scale)
    assert labels(turned, "mug") == ["body", "handle"]


def test_a_mirrored_mug_has_its_handle() -> None:
    """Left-handed input that was wound right again."""
    mirrored = mug()
    mirrored.apply_transform(np.diag([1.0, -1.0, 1.0, 1.0]))
    assert labels(mirrored, "mug") == ["body", "handle"]


def test_a_chair_has_seat_back_and_four_equal_legs() -> None:
    """Equal parts share a label and stay apart."""
    found = labels(chair(), "chair")
    assert [name for name in found if name != "unlabelled"] == ["back", "leg", "leg", "leg", "leg", "seat"]


@pytest.mark.parametrize("category", ["mug", "chair", "table", "bottle", "block", "unknown"])
def test_a_plain_box_or_cylinder_has_no_parts(category: str) -> None:
    """No handle, no leg: the name of a category proves nothing about the shape."""
    assert labels(trimesh.creation.box((0.1, 0.1, 0.1)), category) == []
    assert labels(trimesh.creation.cylinder(0.04, 0.1, sections=64), category) == []


def test_shape_alone_labels_nothing_where_the_category_is_unknown() -> None:
    """A bow on something may be anything."""
    assert set(labels(mug(), "unknown")) <= {"unlabelled"}


def test_names_that_differ_leave_the_part_unlabelled() -> None:
    """The node says lid, the material knob."""
    cube = trimesh.creation.box((0.1, 0.1, 0.1))
    triangles = np.asarray(cube.faces, dtype=np.int32)
    meshes = {
        "lid": Mesh("lid", np.asarray(cube.vertices), triangles, material=0, source_path="/lid"),
        "base": Mesh("base", np.asarray(cube.vertices) + 0.2, triangles, material=1, source_path="/base"),
    }
    found = find_parts(meshes, (Material("knob"), Material("steel")), default("unknown"))
    assert {p.value.label.value for p in found.parts} == {"unlabelled"}
    assert sorted(p.value.may_be for p in found.parts) == [(), ("knob", "lid")]


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("Chair_Leg_FL", "leg"),
        ("legs", "leg"),
        ("battery_cover.001", "battery cover"),
        ("legion", None),
        ("Cube.003", None),
    ],
)
def test_names_of_nodes_name_parts_by_whole_words(name: str, label: str | None) -> None:
    """Plurals and numbers are no hindrance, parts of words no help."""
    assert label_in_name(name, ("leg", "battery cover")) == label


def test_subsets_of_a_package_hold_the_triangles_of_the_part(tmp_path: Path) -> None:
    """Another tool reads the handle from USD alone."""
    shape = mug()
    mesh = Mesh("mug", np.asarray(shape.vertices), np.asarray(shape.faces, dtype=np.int32))
    parts = [p.value for p in find_parts({"mug": mesh}, (), declared("mug", "test")).parts]
    stage = Usd.Stage.CreateInMemory()
    model = Model((mesh,), (), (), (), declared(1.0, "test"), declared("z", "test")).with_mesh_ids()
    author_meshes(stage, Sdf.Path("/mug"), model, materials_per_mesh(model), parts)
    subsets = UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Mesh(stage.GetPrimAtPath("/mug/Visuals/mug")))
    assert {s.GetPrim().GetCustomDataByKey("mana:partLabel") for s in subsets} == {"body", "handle"}
    for subset, part in zip(subsets, parts, strict=True):
        assert list(subset.GetIndicesAttr().Get()) == part.faces[0].indices.tolist()


@pytest.mark.parametrize("thing", MADE, ids=lambda t: t.name)
@pytest.mark.parametrize("seed", [1, 2])
def test_parts_of_one_shell_are_found_however_it_lies(thing: Thing, seed: int) -> None:
    """Turned, mirrored and scaled, the same surface has the same parts, each mostly on its true triangles."""
    R = Rotation.random(rng=np.random.default_rng(seed)).as_matrix() * [1.0, 1.0, (-1.0) ** seed]
    points = (thing.points @ R.T) * 10.0 ** (seed - 2) + 0.3
    triangles = thing.triangles if np.linalg.det(R) > 0.0 else thing.triangles[:, ::-1]
    straight, turned = (
        {
            p.value.label.value: p.value.mask("m", len(t))
            for p in find_parts({"m": Mesh("m", x, t)}, (), declared(thing.category, "test")).parts
        }
        for x, t in ((thing.points, thing.triangles), (points, triangles))
    )
    assert set(straight) == set(turned) == set(thing.parts)
    middles = thing.points[thing.triangles]
    area = np.linalg.norm(np.cross(middles[:, 1] - middles[:, 0], middles[:, 2] - middles[:, 0]), axis=1)
    for index, label in enumerate(thing.parts):
        for found in (straight[label], turned[label]):
            true = thing.owner == index
            assert area[found & true].sum() > 0.5 * area[found | true].sum()


@pytest.mark.parametrize("thing", LIMBED, ids=lambda t: t.name)
@pytest.mark.parametrize("seed", [0, 1])
def test_handles_of_vessels_that_are_not_round_are_thinner_than_the_body(thing: Thing, seed: int) -> None:
    """Walls are thinner still, but the inside of a vessel counts as full."""
    yaw = Rotation.from_euler("z", seed * 0.7).as_matrix()
    points = 10.0**seed * thing.points @ yaw.T
    cavities = find_cavities(Solid(points, thing.triangles, "closed"))
    mesh = Mesh("m", points, thing.triangles)
    parts = [p.value for p in find_parts({"m": mesh}, (), declared(thing.category, "test"), cavities=cavities).parts]
    assert sorted(p.label.value for p in parts) == ["body", "handle"]
    handle = next(p for p in parts if p.label.value == "handle").mask("m", len(thing.triangles))
    true = thing.owner == thing.parts.index("handle")
    assert (handle & true).sum() > 0.8 * (handle | true).sum()


@pytest.mark.parametrize("category", ["mug", "box", "basket", "bin", "tray"])
def test_a_plain_vessel_has_no_limbs(category: str) -> None:
    """Walls and rims are no handles."""
    outer = trimesh.creation.box((0.3, 0.2, 0.15))
    inner = trimesh.creation.box((0.28, 0.18, 0.15)).apply_translation((0.0, 0.0, 0.01))
    assert labels(trimesh.boolean.difference([outer, inner], engine="manifold"), category) == []


@pytest.mark.parametrize("category", ["cooking_utensil", "knife", "spoon", "screwdriver", "drinking_glass"])
def test_a_stick_or_a_wedge_has_no_ends_of_its_own(category: str) -> None:
    """What tapers without a step is all handle, or all head: nobody knows."""
    wedge = trimesh.creation.cone(0.02, 0.3, sections=32)
    assert labels(wedge, category) == labels(trimesh.creation.cylinder(0.01, 0.3), category) == []


def test_a_flat_closure_is_a_cap_and_a_long_one_a_neck() -> None:
    """A hand turns a cap, and wine is poured through a neck."""
    body = trimesh.creation.cylinder(0.035, 0.2).apply_translation((0.0, 0.0, 0.1))
    for length, name in ((0.02, "cap"), (0.09, "neck")):
        end = trimesh.creation.cylinder(0.014, length).apply_translation((0.0, 0.0, 0.2 + length / 2))
        assert labels(trimesh.boolean.union([body, end], engine="manifold"), "bottle") == sorted(["body", name])
