"""What a task leaves of a plan: only what it names, at the same poses as before, and never less than a scene."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cli.main import app
from runtime_plan import Plan, Restriction, prepare, restrict, sample
from runtime_plan.verify import Judge
from schemas.diagnostics import InvalidInput
from schemas.scene.program import Lighting
from tests.support.plan.library import tray_plan

PLAN = prepare(tray_plan())


def with_split() -> Plan:
    return prepare(tray_plan().model_copy(update={"split": {"train": ("cup_a",), "eval": ("cup_b", "plate")}}))


def cups(plan: Plan) -> set[str]:
    drawn = sample(plan, 400, 3)
    return {plan.document.bodies[k].asset_id for k in drawn.asset_index[:, drawn.names.index("cup")].tolist()}


def test_each_side_of_a_split_has_its_own_assets():
    plan = with_split()
    assert cups(plan) == {"cup_a", "cup_b"}
    train, evaluation = restrict(plan, Restriction(split="train")), restrict(plan, Restriction(split="eval"))
    assert cups(train) == {"cup_a"}
    assert cups(evaluation) == {"cup_b"}
    # The plate is for evaluation: no combination with it is left for training.
    assert [one.combination for one in train.document.combinations] == [{"variants.assets": "no_plate"}]
    assert len(evaluation.document.combinations) == 2


def test_names_of_choices_assets_materials_and_lightings_stay():
    restricted = restrict(
        PLAN,
        Restriction(
            choices={"variants.assets": ("as_written",)},
            assets={"cup": ("cup_b",)},
            materials=("felt",),
            lighting=("noon",),
        ),
    )
    drawn = sample(restricted, 300, 0)
    assert cups(restricted) == {"cup_b"}
    assert drawn.present.all()
    assert set(drawn.lighting.tolist()) == {[light.id for light in restricted.document.lighting].index("noon")}
    assert (drawn.material == -1).all()
    felt = [material.id for material in restricted.document.materials].index("felt")
    assert set(drawn.background_material.tolist()) == {-1, felt}
    assert restricted.document.provenance.restricted_from == PLAN.sha256


def test_a_lighting_of_the_task_replaces_those_of_the_scene():
    night = Lighting(id="night", intensity=(1.0, 2.0))
    drawn = sample(restrict(PLAN, Restriction(lighting=(night,))), 200, 5)
    intensity = drawn.channels[:, 0]
    assert np.all((intensity >= 1.0) & (intensity <= 2.0))


def test_layouts_are_those_of_the_whole_plan():
    kept = restrict(PLAN, Restriction(assets={"cup": ("cup_a",)}))
    for one, two in zip(PLAN.document.combinations, kept.document.combinations, strict=True):
        assert one.pools == two.pools
    assert list(Judge(kept).violations(sample(kept, 500, 1))) == []


@pytest.mark.parametrize(
    ("restriction", "code", "said"),
    [
        (Restriction(choices={"variants.asets": ("x",)}), "plan/unknown-choice", "variants.asets"),
        (Restriction(choices={"variants.assets": ("x",)}), "plan/unknown-choice", "as_written"),
        (Restriction(assets={"mug": ("cup_a",)}), "plan/unknown-choice", "no thing `mug`"),
        (Restriction(assets={"cup": ("tray",)}), "plan/unknown-choice", "`cup_a`, `cup_b`"),
        (Restriction(materials=("gold",)), "plan/unknown-choice", "no material `gold`"),
        (Restriction(lighting=("midnight",)), "plan/unknown-choice", "no lighting `midnight`"),
        (Restriction(split="train"), "plan/unknown-choice", "no split"),
        (Restriction(choices={"variants.assets": ()}), "plan/nothing-left", "no combination"),
    ],
)
def test_what_the_plan_does_not_have_is_refused(restriction: Restriction, code: str, said: str):
    with pytest.raises(InvalidInput) as refused:
        restrict(PLAN, restriction)
    assert refused.value.diagnostic.code == code
    assert said in refused.value.diagnostic.headline


def test_the_command_writes_a_plan_that_the_others_read(tmp_path: Path):
    (tmp_path / "plan.json").write_text(tray_plan().model_dump_json())
    run = CliRunner().invoke
    told = json.loads(run(app, ["plan", "inspect", str(tmp_path / "plan.json"), "--json"]).stdout)["choices"]
    assert told["asset"]["cup"] == ["cup_a", "cup_b"]
    assert told["choice"] == {"variants.assets": ["as_written", "no_plate"]}
    written = tmp_path / "train.json"
    words = ["plan", "restrict", str(tmp_path / "plan.json"), "--out", str(written), "--asset", "cup=cup_b", "--json"]
    made = run(app, words)
    assert made.exit_code == 0, made.output
    assert json.loads(made.stdout)["combinations"] == 2
    assert run(app, ["plan", "verify", str(written), "--n", "200", "--json"]).exit_code == 0
    assert run(app, [*words[:-1], "--choice", "nonsense"]).exit_code == 2
