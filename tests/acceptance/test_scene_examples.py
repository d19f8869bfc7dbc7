"""Every program of `examples/scenes` over packages made from the meshes that PyBullet brings, and over mechanisms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cli.demo.scene import scene_demo
from cli.scene.output import write_output
from cli.scene.settle import settled
from gate.external_validators import usd_validation
from scenec.bind.asset_library import AssetLibrary
from scenec.check.judge_scene import violations
from scenec.compile import compile_program
from scenec.ir.problem import Solved
from schemas.scene.runtime_plan import RuntimePlan
from tests.support.plan.draws import draws
from tests.support.scene.articulated import articulated_library
from usdio.reread.body import reread_body
from usdio.reread.scene import reread_scene

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenes"
INFEASIBLE = {"three_cycle"}
MECHANISMS = {"open_drawer", "microwave_door", "two_drawers"}
NAMES = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))


@pytest.fixture(scope="module")
def library(scene_packages: Path) -> AssetLibrary:
    return AssetLibrary(scene_packages)


@pytest.fixture(scope="module")
def mechanisms(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(articulated_library(tmp_path_factory.mktemp("mechanisms")))


def test_there_are_a_dozen():
    assert len(NAMES) >= 12
    assert set(NAMES) > INFEASIBLE


@pytest.mark.parametrize("name", sorted(set(NAMES) - INFEASIBLE - MECHANISMS))
def test_examples_compile_and_stay(name: str, library: AssetLibrary, tmp_path: Path):
    assert_compiles_and_stays(name, library, tmp_path)


@pytest.mark.parametrize("name", sorted(MECHANISMS))
def test_examples_with_mechanisms_compile_and_stay(name: str, mechanisms: AssetLibrary, tmp_path: Path):
    assert_compiles_and_stays(name, mechanisms, tmp_path)


def assert_compiles_and_stays(name: str, library: AssetLibrary, tmp_path: Path):
    compiled = compile_program(EXAMPLES / f"{name}.yaml", library=library, diversity=0.1)
    assert compiled.report.verdict == "compiled", compiled.report.diagnostics
    assert compiled.plan is not None
    for problem, combination in zip(compiled.problems, compiled.plan.combinations, strict=True):
        for placements in draws(compiled.plan, combination, np.random.default_rng(0), 5):
            assert not violations(problem, placements)
    for problem, result in zip(compiled.problems, compiled.results, strict=True):
        assert isinstance(result, Solved)
        assert not violations(problem, result.placements)
    report = write_output(compiled, library.folder, tmp_path)
    assert report.plan is not None
    assert RuntimePlan.model_validate_json((tmp_path / report.plan).read_text()) == compiled.plan
    assert len(report.matrix) == len(compiled.scenes)
    for row, scene in zip(report.matrix, compiled.scenes, strict=True):
        stage = tmp_path / str(row.scene)
        moving = [body.name for body in reread_scene(stage) if body.moves]
        assert moving == [item.id for item in scene.objects]
    verdict = usd_validation(tmp_path / str(report.scene))
    assert verdict.passed, verdict.findings
    assert not [row for row in settled(tmp_path / str(report.scene)) if not row.stayed]


def test_a_scaled_package_keeps_its_density(library: AssetLibrary, tmp_path: Path):
    """At 0.8 of its size the tray weighs 0.512 of what it weighs, and its inertia is 0.8^5 of what it was."""
    compiled = compile_program(EXAMPLES / "tray_of_mugs.yaml", library=library)
    report = write_output(compiled, library.folder, tmp_path)
    tray = next(body for body in reread_scene(tmp_path / str(report.scene)) if body.name == "tray")
    assert library.folder is not None
    whole = reread_body(library.folder / "tray_textured" / "usd" / "tray_textured.usda").mass
    assert tray.body.mass.mass_kg == pytest.approx(0.8**3 * whole.mass_kg, rel=1e-5)
    np.testing.assert_allclose(tray.body.mass.inertia_kgm2, 0.8**5 * whole.inertia_kgm2, rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(tray.body.mass.centre_of_mass_m, 0.8 * whole.centre_of_mass_m, atol=1e-6)


def test_what_is_infeasible_on_purpose_is_proved_so(library: AssetLibrary):
    compiled = compile_program(EXAMPLES / "three_cycle.yaml", library=library)
    assert compiled.report.verdict == "infeasible"
    assert not compiled.scenes
    assert {member.path for member in compiled.report.conflict} == {"relations[0]", "relations[2]", "relations[3]"}
    assert compiled.report.minimal is True


def test_the_demo_compiles_one_scene_and_refuses_the_other(scene_packages: Path, tmp_path: Path):
    demo = scene_demo(scene_packages, tmp_path)
    assert demo is not None
    assert (demo.compiled.verdict, demo.refused.verdict) == ("compiled", "infeasible")
    assert all(row.stayed for row in demo.compiled.settling)
    assert demo.words.startswith("error[scene/relation-cycle]")
    for picture in ("perspective.png", "plan.png", "refused/failure.png"):
        assert (tmp_path / demo.folder / picture).is_file()
    assert not list((tmp_path / demo.folder / "refused").glob("scene*"))
