"""Pairs of materials: complete, within the classes they name, filled in whole, and applied whole or not at all."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import pytest
from pxr import Usd, UsdPhysics, UsdShade

import usdio.write.sample as sample_layer
from assetkit.taxonomy.tables import rows_of
from runtime_plan.bodies import physical_body
from runtime_plan.materials import is_paired, with_material
from scenec.source.paired_materials.library import material_pairs
from scenec.source.read import read_program
from schemas.scene.program import PairedMaterial
from tests.support.bad_inputs.scene import SOUND
from tests.support.plan.library import box_body
from usdio.write.sample import SampleEdit, write_sample

FILLED = ("base_color", "roughness", "metallic", "density_kgm3", "static_friction", "dynamic_friction", "restitution")
SCENE = """#usda 1.0
(
    defaultPrim = "World"
)
def Xform "World"
{
    def Scope "Objects"
    {
        def Xform "a" (
            prepend apiSchemas = ["PhysicsMassAPI"]
            customData = {
                dictionary mana = {
                    string id = "a"
                }
            }
        )
        {
            float physics:mass = 0.4
            float3 physics:diagonalInertia = (0.1, 0.2, 0.3)
            def Cube "c"
            {
            }
        }
    }
}
"""


def written(folder: Path, material: str) -> tuple[PairedMaterial, ...]:
    program = folder / "program.yaml"
    program.write_text(SOUND + f"variants:\n  materials:\n    - {{id: m, objects: [a], {material}}}\n")
    read = read_program(program)
    assert read.program is not None, [d.headline for d in read.diagnostics]
    return read.program.variants.materials


def test_twelve_pairs_and_more_each_with_two_sourced_records() -> None:
    assert len(material_pairs()) >= 12
    for pair in material_pairs().values():
        assert all(0.0 <= channel <= 1.0 for channel in (*pair.render.base_color, *astuple(pair.render)[1:3]))
        assert pair.physical.dynamic_friction <= pair.physical.static_friction
        assert pair.render.source
        assert pair.physical.source


@pytest.mark.parametrize("name", material_pairs())
def test_contact_values_lie_within_those_of_the_class(name: str) -> None:
    """The material table of assets holds bounds with sources; light metals and foams are denser or lighter by class."""
    physical = material_pairs()[name].physical
    (row,) = [row for row in rows_of("materials.csv") if row["name"] == physical.material_class]
    assert float(row["friction_low"]) <= physical.dynamic_friction
    assert physical.static_friction <= float(row["friction_high"])
    assert float(row["restitution_low"]) <= physical.restitution <= float(row["restitution_high"])
    assert float(row["density_low"]) <= physical.density_kgm3 <= float(row["density_high"])


@pytest.mark.parametrize("name", material_pairs())
def test_a_program_that_names_a_pair_has_all_its_values(name: str, tmp_path: Path) -> None:
    (material,) = written(tmp_path, f"pair: {name}")
    assert None not in [getattr(material, field) for field in FILLED]
    assert is_paired(material)


def test_what_the_program_states_itself_stays(tmp_path: Path) -> None:
    (material,) = written(tmp_path, "pair: brass, roughness: 0.9, static_friction: 0.2")
    assert (material.roughness, material.static_friction) == (0.9, 0.2)
    assert material.density_kgm3 == material_pairs()["brass"].physical.density_kgm3


def test_an_unknown_pair_is_reported_where_it_stands(tmp_path: Path) -> None:
    program = tmp_path / "program.yaml"
    program.write_text(SOUND + "variants:\n  materials:\n    - {id: m, objects: [a], pair: bras}\n")
    read = read_program(program)
    (diagnostic,) = read.diagnostics
    assert (read.program, diagnostic.code) == (None, "scene/unknown-name")
    assert "brass" in diagnostic.headline
    assert diagnostic.where.line == len(SOUND.splitlines()) + 3


def edit_of(name: str) -> SampleEdit:
    pair = material_pairs()[name]
    values = {field: getattr(pair.render, field) for field in FILLED[:3]}
    values |= {field: getattr(pair.physical, field) for field in FILLED[3:]}
    material = PairedMaterial(id=name, objects=("a",), **values)
    own = physical_body(box_body("a", 0.1, 0.1, mass_kg=0.4), None)
    dressed = with_material(own.body, 400.0, material)
    factor = dressed.mass.mass_kg / own.body.mass.mass_kg
    return SampleEdit("a", material=material, contact=dressed.contact, density_factor=factor)


def state_of(layer: Path) -> tuple[object, ...]:
    """Colour, friction and mass of the object in a sample layer."""
    stage = Usd.Stage.Open(str(layer))
    prim = stage.GetPrimAtPath("/World/Objects/a")
    look, _ = UsdShade.MaterialBindingAPI(prim.GetChild("c")).ComputeBoundMaterial()
    touch, _ = UsdShade.MaterialBindingAPI(prim.GetChild("c")).ComputeBoundMaterial("physics")
    color = look.ComputeSurfaceSource()[0].GetInput("diffuseColor").Get()
    friction = UsdPhysics.MaterialAPI(touch.GetPrim()).GetDynamicFrictionAttr().Get()
    return tuple(color), friction, UsdPhysics.MassAPI(prim).GetMassAttr().Get()


@pytest.mark.parametrize("fault", ["_surface", "author_contact_values", "label_material"])
def test_look_and_physics_change_together_or_not_at_all(
    fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fault at any step of the second substitution leaves the first one as it is on disk, and no new file."""
    scene, layer = tmp_path / "scene.usda", tmp_path / "sample.usda"
    scene.write_text(SCENE)
    write_sample(scene, [edit_of("cardboard")], None, tmp_path, layer)
    cardboard, data = state_of(layer), layer.read_bytes()
    assert cardboard == (
        pytest.approx(material_pairs()["cardboard"].render.base_color),
        pytest.approx(0.35),
        pytest.approx(0.4 * 700.0 / 400.0),
    )

    def fail(*_: object) -> None:
        raise RuntimeError("injected")

    with monkeypatch.context() as broken:
        broken.setattr(sample_layer, fault, fail)
        for file in (layer, tmp_path / "new.usda"):
            with pytest.raises(RuntimeError, match="injected"):
                write_sample(scene, [edit_of("iron")], None, tmp_path, file)
    assert (layer.read_bytes(), state_of(layer)) == (data, cardboard)
    assert not (tmp_path / "new.usda").exists()
    write_sample(scene, [edit_of("iron")], None, tmp_path, layer)
    iron = state_of(layer)
    assert iron[1:] == (pytest.approx(0.4), pytest.approx(0.4 * 7870.0 / 400.0))
