"""Which parts of an object go together, and what each is made of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from assetkit.mass.substances import substances_of, uniform
from assetkit.options import Options
from assetkit.taxonomy.material_classes import UNKNOWN
from benchmarks.assets.truth_files import object_of
from schemas.diagnostics import Location
from schemas.stated_physics import StatedMass
from tests.support.package_samples import box_mesh


def named(*names: str):
    return [replace(box_mesh(name=name), source_path=f"/{name}") for name in names]


def kinds(meshes, materials=(), whole=("thing.glb",), stated=()) -> dict[str, tuple[str, ...]]:
    substances = substances_of(meshes, materials, whole, stated)
    return {s.material.value: s.names for s in substances}


def test_render_material_and_mesh_names_tell_parts_apart():
    meshes = [replace(m, material=i) for i, m in enumerate(named("head", "handle", "grip"))]
    found = kinds(meshes, ("BrushedSteel", "Oak", "Material.003"))
    assert found == {"steel": ("head",), "wood": ("handle",), UNKNOWN: ("grip",)}


def test_the_file_name_fills_in_with_less_confidence():
    found = substances_of(named("leg", "steel_screw"), (), ("wooden_chair.glb",), ())
    assert {s.material.value: s.names for s in found} == {"wood": ("leg",), "steel": ("steel_screw",)}
    assert found[0].material.confidence < found[1].material.confidence


def test_one_class_throughout_is_one_substance_that_all_names_vote_on():
    (only,) = substances_of(named("oak_leg", "pine_seat", "oak_back"), (), ("stool.obj",), ())
    assert (only.meshes, only.material.value) == ((0, 1, 2), "wood")
    assert only.material.inputs == ("oak_leg", "pine_seat", "oak_back")
    (only,) = substances_of(named("a", "b"), (), ("thing.obj",), ())
    assert only.material.value == UNKNOWN


def test_a_stated_mass_keeps_its_meshes_together_and_a_density_replaces_the_class():
    mass = StatedMass(("/oak", "/steel"), 24, "test", Location(), mass_kg=2.0)
    density = StatedMass(("/rest",), 12, "test", Location(), density=123.0)
    first, second, third = substances_of(named("oak", "steel", "rest", "plain"), (), ("x.usd",), [mass, density])
    assert (first.names, first.stated) == (("oak", "steel"), mass)
    assert (second.names, second.density_kgm3.value, second.density_kgm3.source) == (("rest",), 123.0, "declared")
    assert not second.may_be_hollow
    assert (third.names, third.material.value) == (("plain",), UNKNOWN)


@pytest.mark.parametrize(("full", "density", "hollow"), [(False, 500.0, True), (True, 1000.0, False)])
def test_unknown_walls_are_full_and_unknown_blocks_may_be_hollow(full, density, hollow):
    substance = uniform(["thing"], full=full)
    assert (substance.density_kgm3.value, substance.may_be_hollow) == (density, hollow)
    assert substance.material.value == UNKNOWN


def test_unknown_full_material_says_what_its_bounds_leave_out():
    """A brass goblet or a gold ring weighs more than the densest unknown body: the bounds must not hide that."""
    method = uniform(["goblet"], full=True).density_kgm3.method
    for name, density in (("solid brass", 8500.0), ("solid gold", 19300.0), ("cork or balsa", 160.0)):
        low, high = uniform(["goblet"], full=True).density_kgm3.bounds or (0.0, 0.0)
        assert not low <= density <= high
        assert name in method.split("; outside: ")[1]
    assert "steel" not in method
    assert "outside" not in uniform(["wood"], full=True).density_kgm3.method


def test_components_of_machines_are_as_dense_as_makers_say_and_the_rest_stays_unknown():
    found = substances_of(named("arms", "battery", "battery_holder", "Motor_1", "motors"), (), ("flyer.usd",), ())
    low_high = {s.names: s.density_kgm3.bounds for s in found}
    assert low_high[("battery",)] == (1500.0, 3300.0)
    assert low_high[("Motor_1", "motors")] == (2000.0, 6500.0)
    rest = next(s for s in found if s.names == ("arms", "battery_holder"))
    assert (rest.density_kgm3.source, rest.density_kgm3.confidence) == ("default", 0.0)
    assert all(s.density_kgm3.source == "inferred" and not s.may_be_hollow for s in found if s is not rest)


def test_a_component_in_a_file_of_a_known_material_is_of_that_material():
    (only,) = substances_of(named("battery", "body"), (), ("plastic_toy.obj",), ())
    assert only.material.value == "plastic"


def test_a_component_alone_is_dense_and_a_word_within_another_is_none():
    (magnet,) = substances_of(named("magnet.001"), (), ("part.stl",), ())
    assert magnet.density_kgm3.bounds == (4700.0, 7700.0)
    (holder,) = substances_of(named("magnetic_base"), (), ("part.stl",), ())
    assert holder.density_kgm3.source == "default"


@pytest.mark.shared
def test_components_of_a_real_quadcopter(shared_assets: Path):
    """Its battery, motors and propellers are known; mounts, holders, boards and pins are none of these."""
    folder = shared_assets / "usd" / "nwt_crazyflie_usd"
    meshes = object_of(folder / "crazyflie.usd", Options(), folder).model.meshes
    found = substances_of(meshes, (), ("crazyflie.usd",), ())
    assert {s.names: s.density_kgm3.bounds for s in found if s.density_kgm3.source == "inferred"} == {
        ("battery",): (1500.0, 3300.0),
        ("motors",): (2000.0, 6500.0),
        ("propeller",) * 4: (900.0, 1900.0),
    }
    (rest,) = (s for s in found if s.density_kgm3.source == "default")
    assert rest.names == ("arms", "battery_holder", "board", "motor_mounts", "pin_racks", "pins")
