"""The same draw by another array library: the same words, the same choices, poses to a micrometre."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from examples.reset_environments import parked, slots
from runtime_plan import prepare, sample
from runtime_plan.philox import philox
from tests.support.plan import torch_draws
from tests.support.plan.library import grid_plan, tray_plan

PLANS = {"grid": prepare(grid_plan(12, 40)), "tray": prepare(tray_plan())}
POSES = ("position_m", "quat_wxyz", "yaw_rad", "channels")
CHOICES = ("combination", "case", "present", "asset_index", "stance", "support", "material", "background_material",
           "background", "lighting")  # fmt: skip


@given(seed=st.integers(0, 2**64 - 1), start=st.integers(0, 2**60))
def test_words_in_signed_integers_are_those_of_numpy(seed: int, start: int):
    counter = np.arange(start + 1, start + 65, dtype=np.int64)
    words = np.stack(philox(counter, seed), axis=-1).astype(np.uint64).reshape(-1)
    np.testing.assert_array_equal(words, np.random.Philox(key=seed, counter=start).random_raw(256))


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What PyTorch answers for each plan."""
    folder: Path = tmp_path_factory.mktemp("torch")
    for name, plan in PLANS.items():
        (folder / f"{name}.json").write_text(plan.document.model_dump_json())
    torch_draws.answered(folder)
    return {name: np.load(folder / f"{name}.npz") for name in PLANS}


@pytest.mark.parametrize("name", sorted(PLANS))
def test_torch_draws_the_same_scenes(name: str, answers: dict[str, Any]):
    drawn = sample(PLANS[name], torch_draws.COUNT, torch_draws.SEED, start=torch_draws.START)
    for field in CHOICES:
        np.testing.assert_array_equal(answers[name][field], getattr(drawn, field), err_msg=field)
    for field in POSES:
        np.testing.assert_allclose(answers[name][field], getattr(drawn, field), atol=1e-6, rtol=0, err_msg=field)


@pytest.mark.parametrize("name", sorted(PLANS))
def test_environments_of_isaac_lab_stand_as_the_samples_say_and_what_is_absent_is_parked(
    name: str, answers: dict[str, Any]
):
    plan, answer = PLANS[name], answers[name]
    count, ended = torch_draws.ENVIRONMENTS, torch_draws.ENDED
    first = sample(plan, count, torch_draws.SEED)
    later = sample(plan, len(ended), torch_draws.SEED, start=count)
    parks = 0
    for slot, (thing, asset) in enumerate(slots(plan)):
        column = first.names.index(thing)
        for environment in range(count):
            drawn, k = (later, ended.index(environment)) if environment in ended else (first, environment)
            body = int(drawn.asset_index[k, column])
            there = body >= 0 and plan.document.bodies[body].asset_id == asset
            parks += not there
            at = drawn.position_m[k, column] if there else parked(slot)
            quat = drawn.quat_wxyz[k, column] if there else (1.0, 0.0, 0.0, 0.0)
            pose = answer["root_pose"][slot, environment]
            wanted = at + answer["env_origins"][environment]  # 32-bit floats: to 1e-7 of what they say
            np.testing.assert_allclose(pose[:3], wanted, rtol=1e-6, atol=1e-6)
            np.testing.assert_allclose(pose[3:], quat, atol=1e-6)
    assert not answer["root_velocity"].any()
    assert (parks > 0) == (name == "tray")
