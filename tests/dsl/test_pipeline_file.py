"""Pipelines: the paper's listings, what they are lowered to, and every error of all fragments in one run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from dsl.pipeline_file import PipelineFile, read_pipeline
from schemas.codes import CODES
from schemas.task.orders import Orders
from tests.support.bad_inputs.pipeline import CHANGES, SOUND, sample, write

EXAMPLE = Path(__file__).parents[2] / "examples" / "pipelines" / "pick_place" / "pipeline.yaml"
SIMULATORS = ("pybullet", "mujoco", "pxr", "vtk", "vtkmodules", "trimesh", "bpy")


def sound(text: str, folder: Path) -> PipelineFile:
    """The pipeline of a text without an error."""
    file, diagnostics = read_pipeline(write(text, folder))
    assert file is not None, diagnostics
    return file


def test_the_listings_of_the_paper_are_lowered() -> None:
    file, diagnostics = read_pipeline(EXAMPLE)
    assert file is not None
    orders = file.orders
    assert [order.name for order in orders.scenes] == ["pick_place", "pick_place_ood"]
    assert orders.scenes[0].program["objects"] == orders.scenes[1].program["objects"]
    assert (orders.robots[0].name, orders.robots[0].gripper_variant) == ("ARM-G", "G")
    (assembly,) = orders.assemblies
    assert assembly.bindings == {"@container": ("basket",), "@pickable": ("mug",)}
    assert [node.points for node in orders.tasks[0].nodes] == [(15, 2), (5, 2)]
    assert [(order.teacher, order.modes) for order in orders.rollouts] == [
        ("teleop", ("gendata",)),
        ("PolicyPlanner", ("benchmark",)),
    ]
    assert orders.rollouts[1].settings == {"policy_cfg": {"server": "tcp://localhost:5555"}}
    assert {d.code for d in diagnostics} == {"pipeline/unused-order", "task/points-normalised"}


def test_a_benchmark_refuses_points_that_are_not_ten() -> None:
    file, diagnostics = read_pipeline(EXAMPLE, benchmark=True)
    assert file is None
    assert "task/points-not-ten" in {d.code for d in diagnostics}


@pytest.mark.parametrize("code", sorted(CHANGES))
def test_a_sample_gives_its_code_alone_with_place_and_help(code: str, tmp_path: Path) -> None:
    assert CHANGES.keys() == {c for c in CODES if c.startswith("pipeline/")}
    _, diagnostics = read_pipeline(write(sample(code), tmp_path))
    assert [d.code for d in diagnostics] == [code]
    assert diagnostics[0].where.line
    assert diagnostics[0].help == CODES[code].help


def test_errors_of_all_fragments_come_in_one_run(tmp_path: Path) -> None:
    text = SOUND.replace("asset: {type: cylinder, radius_m: 0.04", "asset: {type: cylindre, radius_m: 0.04")
    text = text.replace("_func: upright", "_func: uprigt").replace("env_ref: env", "env_ref: enw")
    text = text.replace("robot_generator_name: arm", "robot_generator_name: arms")
    file, diagnostics = read_pipeline(write(text, tmp_path))
    assert file is None
    places = [(d.code, d.where.line) for d in diagnostics]
    lines = text.splitlines()
    assert places == [
        ("scene/invalid-value", 1 + next(k for k, line in enumerate(lines) if "cylindre" in line)),
        ("task/unknown-predicate", 1 + next(k for k, line in enumerate(lines) if "uprigt" in line)),
        ("pipeline/unknown-name", 1 + next(k for k, line in enumerate(lines) if "_name: arms" in line)),
        ("pipeline/unknown-name", 1 + next(k for k, line in enumerate(lines) if "enw" in line)),
    ]
    assert "did you mean `arm`?" in diagnostics[2].headline


def test_orders_do_not_depend_on_comments_space_or_the_file(tmp_path: Path) -> None:
    before = sound(SOUND, tmp_path).orders
    spaced = "# a comment\n" + SOUND.replace("rollout:", "\n\nrollout:   # another")
    (tmp_path / "other").mkdir()
    after = sound(spaced, tmp_path / "other").orders
    assert before == after
    assert [order.digest for order in before.all()] == [order.digest for order in after.all()]


def test_orders_survive_their_json_and_change_with_what_they_hold(tmp_path: Path) -> None:
    orders = sound(SOUND, tmp_path).orders
    assert Orders.model_validate_json(json.dumps(orders.model_dump(mode="json"))) == orders
    changed = sound(SOUND.replace("radius_m: 0.04", "radius_m: 0.05"), tmp_path).orders
    assert changed.scenes[0].digest != orders.scenes[0].digest
    assert changed.tasks[0].digest == orders.tasks[0].digest


def test_roles_of_the_task_win_over_tags(tmp_path: Path) -> None:
    text = SOUND.replace("  - task: stand\n", "  - task: stand\n    roles: {pickable: can}\n")
    assert sound(text, tmp_path).orders.assemblies[0].bindings == {"@pickable": ("can",)}


def test_no_simulator_usd_or_renderer_is_imported() -> None:
    code = (
        "import sys\nfrom pathlib import Path\nfrom dsl.pipeline_file import read_pipeline\n"
        f"file, _ = read_pipeline(Path({str(EXAMPLE)!r}))\nassert file is not None\n"
        f"print([name for name in {SIMULATORS!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
