"""What conditions need of a scene's assets, by their records, before any episode."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dsl.pipeline_file import read_pipeline
from tests.support.bad_inputs.pipeline import SOUND, write
from tests.task.world import inside

RECORD = Path(__file__).parents[1] / "data" / "record.json"
INLINE = "{type: cylinder, radius_m: 0.03, height_m: 0.1}"
ONE = "{_func: upright, object: '@pickable'}"
INSIDE = "{_func: inside, object: '@pickable', container: can}"


def library(folder: Path, **anchors: bool) -> Path:
    """Packages by name: copies of the sample record, with a volume or without."""
    volume = {"value": inside(0.03, 0.08, 0.01).model_dump(mode="json"), "source": "measured", "method": "test"}
    for name, has_volume in anchors.items():
        record = json.loads(RECORD.read_text())
        record["anchors"] = [volume | {"confidence": 0.9}] if has_volume else []
        (folder / "library" / name).mkdir(parents=True)
        (folder / "library" / name / "record.json").write_text(json.dumps(record | {"asset_id": name}))
    return folder / "library"


def found(success: str, asset: str, folder: Path, assets: Path | None) -> list[str]:
    """Values of what is missing."""
    text = SOUND.replace(ONE, success).replace(INLINE, asset)
    _, diagnostics = read_pipeline(write(text, folder), assets=assets)
    assert {d.code for d in diagnostics} <= {"pipeline/unmet-need"}
    return [str(d.value) for d in diagnostics]


def test_a_container_without_an_inside_is_found_and_one_with_it_passes(tmp_path: Path) -> None:
    assets = library(tmp_path, mug=True, lid=False)
    assert found(INSIDE, "mug", tmp_path, assets) == []
    assert found(INSIDE, "lid", tmp_path, assets) == ["`can` has no volume `auto`; it has none"]


def test_a_pool_has_what_all_its_assets_have(tmp_path: Path) -> None:
    assets = library(tmp_path, mug=True, cup=True, lid=False)
    pool = "{{type: pool, candidates: [{{id: any, assets: [{}]}}]}}"
    assert found(INSIDE, pool.format("mug, cup"), tmp_path, assets) == []
    assert found(INSIDE, pool.format("mug, lid"), tmp_path, assets) == ["`can` has no volume `auto`; it has none"]


@pytest.mark.parametrize("asset", ["absent", "../mug", INLINE])
def test_what_is_not_known_lacks_nothing_and_inline_shapes_are_known(asset: str, tmp_path: Path) -> None:
    assets = library(tmp_path, mug=True)
    missing = found(INSIDE, asset, tmp_path, assets)
    assert missing == (["`can` has no volume `auto`; it has none"] if asset == INLINE else [])


def test_joints_and_conditions_within_others_are_checked(tmp_path: Path) -> None:
    assets = library(tmp_path, mug=True)
    joint = "{_func: dwell, for_s: 1, of: {_func: joint_at, joint: can/lid, at_least: 0.1}}"
    assert found(joint, "mug", tmp_path, assets) == ["there is no joint `can/lid`"]
    counted = f"{{_func: counted, members: [cup], exactly: 1, where: {INSIDE.replace(repr('@pickable'), '$member')}}}"
    assert found(counted, INLINE, tmp_path, assets) == ["`can` has no volume `auto`; it has none"]


def test_what_is_known_is_checked_beside_what_is_not(tmp_path: Path) -> None:
    on = "{_func: on, object: cup, support: can, surface: lid}"
    text = SOUND.replace(ONE, on).replace("{type: cylinder, radius_m: 0.04, height_m: 0.1}", "absent")
    _, diagnostics = read_pipeline(write(text, tmp_path), assets=library(tmp_path, mug=True))
    assert [str(d.value) for d in diagnostics] == ["`can` has no surface `lid`; it has top"]
