"""Samples written are the samples read; files of other plans and broken files are refused."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from runtime_plan import as_document, prepare, read_samples, sample
from schemas.diagnostics import InvalidInput
from tests.support.plan.library import grid_plan, tray_plan

PLAN = prepare(tray_plan())


def written(folder: Path, n: int = 40) -> Path:
    path = folder / "samples.json"
    path.write_text(as_document(PLAN, sample(PLAN, n, 3, start=5)).model_dump_json())
    return path


def test_what_is_written_is_read_to_the_bit(tmp_path: Path):
    drawn = sample(PLAN, 40, 3, start=5)
    indices, read = read_samples(written(tmp_path), PLAN)
    assert indices == tuple(range(5, 45))
    for name in ("combination", "case", "present", "asset_index", "support", "position_m", "quat_wxyz", "material",
                 "background_material", "background", "lighting", "channels"):  # fmt: skip
        np.testing.assert_array_equal(getattr(read, name), getattr(drawn, name), err_msg=name)


def test_the_file_has_the_shape_that_other_tools_rely_on(tmp_path: Path):
    document = json.loads(written(tmp_path).read_text())
    assert {"schema_version", "plan", "seed", "samples"} <= set(document)
    first = document["samples"][0]
    assert {"index", "case", "objects", "lighting", "background"} <= set(first)
    assert {"asset", "position_m", "quat_wxyz", "support", "material"} == set(first["objects"]["cup"])
    assert first["objects"]["cup"]["support"] == "tray"


def test_samples_of_another_plan_are_refused(tmp_path: Path):
    with pytest.raises(InvalidInput) as refused:
        read_samples(written(tmp_path), prepare(grid_plan(2, 1)))
    assert refused.value.diagnostic.code == "plan/other-plan"


@pytest.mark.parametrize("text", ["{", "[]", '"cup": {"asset": "brick"', '"support":"moon"', '"combination":7'])
def test_broken_samples_are_refused(tmp_path: Path, text: str):
    path = written(tmp_path, 1)
    whole = path.read_text()
    key = text.split(":")[0]
    if key == '"cup"':
        broken = whole.replace('"asset":"cup_a"', '"asset":"brick"').replace('"asset":"cup_b"', '"asset":"brick"')
    elif key == '"support"':
        broken = whole.replace('"support":"tray"', text)
    elif key == '"combination"':
        broken = whole.replace('"combination":0', text).replace('"combination":1', text)
    else:
        broken = text
    path.write_text(broken)
    with pytest.raises(InvalidInput) as refused:
        read_samples(path, PLAN)
    assert refused.value.diagnostic.code == "plan/unreadable-samples"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d["samples"].clear(), "no sample"),
        (lambda d: d["samples"][1].update(index=d["samples"][0]["index"]), "one index"),
        (lambda d: d["samples"][0]["objects"]["cup"].update(quat_wxyz=[2.0, 0.0, 0.0, 0.0]), "no unit length"),
        (lambda d: d["samples"][0]["objects"]["cup"].update(position_m=[float("nan"), 0.0, 0.0]), "not finite"),
    ],
)
def test_samples_that_cannot_be_judged_are_refused(tmp_path: Path, change: Callable[[dict], None], said: str):
    plan = prepare(tray_plan())
    document = json.loads(as_document(plan, sample(plan, 3, 0)).model_dump_json())
    change(document)
    (tmp_path / "s.json").write_text(json.dumps(document))
    with pytest.raises(InvalidInput) as refused:
        read_samples(tmp_path / "s.json", plan)
    assert refused.value.diagnostic.code == "plan/unreadable-samples"
    assert said in refused.value.diagnostic.headline
