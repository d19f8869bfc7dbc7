"""The same draw by another array library: the same words, the same choices, poses to a micrometre."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime_plan import prepare, sample
from runtime_plan.philox import philox
from tests.plan_library import grid_plan, tray_plan

CHOICES = ("combination", "case", "present", "asset_index", "stance", "support", "material", "background_material",
           "background", "lighting")  # fmt: skip


@given(seed=st.integers(0, 2**64 - 1), start=st.integers(0, 2**60))
def test_words_in_signed_integers_are_those_of_numpy(seed: int, start: int):
    counter = np.arange(start + 1, start + 65, dtype=np.int64)
    words = np.stack(philox(counter, seed), axis=-1).astype(np.uint64).reshape(-1)
    np.testing.assert_array_equal(words, np.random.Philox(key=seed, counter=start).random_raw(256))


@pytest.mark.parametrize("document", [grid_plan(12, 40), tray_plan()], ids=["grid", "tray"])
def test_torch_draws_the_same_scenes(document):
    pytest.importorskip("torch", reason="PyTorch is optional")
    from runtime_plan.torch_sampler import TorchSampler

    plan = prepare(document)
    one, two = sample(plan, 1000, 2**63 + 5, start=70), TorchSampler(plan).sample(1000, 2**63 + 5, start=70)
    for name in CHOICES:
        np.testing.assert_array_equal(getattr(two, name).numpy(), getattr(one, name), err_msg=name)
    for name in ("position_m", "quat_wxyz", "yaw_rad", "channels"):
        np.testing.assert_allclose(getattr(two, name).numpy(), getattr(one, name), atol=1e-6, rtol=0, err_msg=name)
