"""Samples in PyBullet: bodies are built once, poses follow, materials come whole."""

from pathlib import Path

import numpy as np
import pytest

from geom.pose import pose, pose_from_quat
from runtime_plan import prepare, sample
from runtime_plan.bodies import physical_body
from runtime_plan.materials import is_paired, with_material
from runtime_plan.realise import Realiser
from schemas.diagnostics import InvalidInput
from schemas.physics import Contact, MassProperties
from schemas.scene.program import PairedMaterial
from schemas.scene.runtime_plan import PlanBody
from sim.bullet.resets import BulletResets
from sim.bullet.world import private_client
from tests.support.plan.library import box_body, tray_plan

WORN = (
    tray_plan()
    .combinations[0]
    .model_copy(update={"things": tray_plan().combinations[1].things, "pools": tray_plan().combinations[1].pools})
)


def plan_with_materials():
    """The tray, the cup and the block, with materials; no plate, which is no primitive."""
    return prepare(tray_plan().model_copy(update={"combinations": (WORN,)}))


def test_bodies_are_built_once_and_stand_where_the_sample_says():
    plan = plan_with_materials()
    drawn = sample(plan, 40, 3)
    with private_client() as client:
        world = BulletResets(client)
        realiser = Realiser(plan, None, world)
        counts = []
        for k in range(40):
            numbers = realiser.reset(drawn, k)
            poses = world.poses()
            for column, name in enumerate(drawn.names):
                wanted = pose_from_quat(drawn.quat_wxyz[k, column], drawn.position_m[k, column])
                np.testing.assert_allclose(poses[numbers[name]], wanted, atol=1e-9)
            counts.append(len(world))
    assert counts[-1] == 5  # table, tray, block, and a cup of two kinds
    assert counts[20] == counts[-1]


def test_a_sampled_scene_stays_where_it_was_put():
    plan = plan_with_materials()
    drawn = sample(plan, 3, 8)
    with private_client() as client:
        world = BulletResets(client)
        realiser = Realiser(plan, None, world)
        for k in range(3):
            numbers = realiser.reset(drawn, k)
            before = world.poses()
            world.run(0.5)
            moved = np.linalg.norm((world.poses() - before)[list(numbers.values()), :3, 3], axis=1)
            assert moved.max() < 0.005


def test_a_paired_material_changes_mass_inertia_and_friction_together():
    plan = plan_with_materials()
    drawn = sample(plan, 60, 1)
    tray, block = drawn.names.index("tray"), drawn.names.index("block")
    seen = set()
    with private_client() as client:
        world = BulletResets(client)
        realiser = Realiser(plan, None, world)
        own = physical_body(plan.document.bodies[1], None)
        moments = np.sort(np.linalg.eigvalsh(own.body.mass.inertia_kgm2))
        for k in range(60):
            numbers = realiser.reset(drawn, k)
            density = {-1: own.density_kgm3, 0: 7800.0, 1: 600.0}[int(drawn.material[k, tray])]
            mass, inertia, _ = world.dynamics(numbers["tray"])
            assert mass == pytest.approx(0.5 * density / own.density_kgm3)
            np.testing.assert_allclose(np.sort(inertia), moments * mass / 0.5, rtol=1e-6)
            assert (drawn.material[k, block] == 1) == (drawn.material[k, tray] == 1)
            seen.add(int(drawn.material[k, tray]))
    assert seen == {-1, 0, 1}


def test_friction_of_a_support_follows_its_material():
    plan = plan_with_materials()
    drawn = sample(plan, 20, 1)
    with private_client() as client:
        world = BulletResets(client)
        realiser = Realiser(plan, None, world)
        for k in range(20):
            realiser.reset(drawn, k)
            felt = drawn.background_material[k] == 2
            assert world.dynamics(0)[2] == pytest.approx(0.9**0.5 if felt else 0.5**0.5)


def test_a_paired_material_brings_its_restitution():
    """A cube falls 30 cm on a slab; both have the material, and the rebound shows it."""

    def rebound_m(restitution: float) -> float:
        rubber = PairedMaterial(id="rubber", objects=("cube", "slab"), restitution=restitution)
        with private_client() as client:
            world = BulletResets(client)
            for name, side_m, centre_m in (("slab", 1.0, -0.1), ("cube", 0.1, 0.3)):
                own = physical_body(box_body(name, side_m, 0.1, mass_kg=0.4), None)
                worn = with_material(own.body, None, rubber)
                number = world.add(own.body, moves=name == "cube")
                world.set_material(number, worn.mass, worn.contact)
                world.set_pose(number, pose(None, np.array([0.0, 0.0, centre_m])))
            heights = []
            for _ in range(120):
                world.run(1.0 / 240.0)
                heights.append(float(world.poses()[1, 2, 3]))
        low = int(np.argmin(heights[:90]))
        return max(heights[low:]) - heights[low]

    assert rebound_m(0.0) < 0.005
    assert rebound_m(0.8) > 0.1


def test_a_recipe_of_appearance_leaves_physics_untouched():
    own = physical_body(box_body("box", 0.1, 0.1, mass_kg=0.4), None)
    red = PairedMaterial(id="red", objects=("box",), base_color=(1.0, 0.0, 0.0), roughness=0.2, metallic=0.0)
    assert not is_paired(red)
    assert with_material(own.body, own.density_kgm3, red) is own.body
    assert with_material(own.body, own.density_kgm3, None) is own.body


def test_dynamic_friction_never_exceeds_static():
    own = physical_body(box_body("box", 0.1, 0.1, mass_kg=0.4), None)
    grippy = with_material(own.body, None, PairedMaterial(id="g", objects=("box",), dynamic_friction=0.9))
    assert grippy.contact.static_friction == grippy.contact.dynamic_friction == 0.9
    slick = with_material(own.body, None, PairedMaterial(id="s", objects=("box",), static_friction=0.2))
    assert slick.contact.dynamic_friction == slick.contact.static_friction == 0.2
    assert slick.mass.mass_kg == own.body.mass.mass_kg


@pytest.mark.parametrize("text", ["{", "{}", "[]"])
def test_a_damaged_record_is_told_with_its_package(tmp_path: Path, text: str):
    (tmp_path / "mug").mkdir()
    (tmp_path / "mug" / "record.json").write_text(text)
    with pytest.raises(InvalidInput) as refused:
        physical_body(PlanBody(asset_id="mug", package="mug", stances=()), tmp_path)
    assert refused.value.diagnostic.code == "plan/changed-package"
    assert "mug" in refused.value.diagnostic.headline


def test_a_material_that_could_not_be_set_is_set_by_the_next_reset(monkeypatch: pytest.MonkeyPatch):
    """The world fails once, at every body in turn: the next reset of the same sample gives what it gives without."""
    plan = plan_with_materials()
    drawn = sample(plan, 60, 1)
    tray = drawn.names.index("tray")
    k = int(np.flatnonzero(drawn.material[:, tray] == 0)[0])

    def dynamics(failing: int | None) -> list[float]:
        with private_client() as client:
            world = BulletResets(client)
            realiser, calls = Realiser(plan, None, world), 0
            whole = world.set_material

            def once(number: int, mass: MassProperties, contact: Contact) -> None:
                nonlocal calls
                calls += 1
                if calls == failing:
                    raise RuntimeError("injected")
                whole(number, mass, contact)

            monkeypatch.setattr(world, "set_material", once)
            if failing is not None:
                with pytest.raises(RuntimeError, match="injected"):
                    realiser.reset(drawn, k)
            numbers = realiser.reset(drawn, k)
            mass, inertia, friction = world.dynamics(numbers["tray"])
            return [mass, *inertia, friction]

    for failing in (1, 2, 3, 4, 5, 6):
        np.testing.assert_allclose(dynamics(failing), dynamics(None), rtol=1e-9)
