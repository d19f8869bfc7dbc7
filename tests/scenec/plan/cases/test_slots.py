"""Structured families cut a place into slots: inside it, apart, and large enough for their things."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.scenes.workload import sizes_and_pairs, workload
from scenec.ir.problem import Placement
from scenec.plan.cases.pool import FAMILIES
from scenec.plan.cases.pool_model import pool_model_of
from scenec.plan.cases.slots import SlotOptions, slot_options_of
from scenec.solve.model import model_of
from schemas.scene.geometry import Domain

BOX_M, GAP_M = np.array([-0.6, 0.6, -0.4, 0.4]), 0.01


def slot_options_for(n: int) -> SlotOptions:
    """Boxes of 4 to 14 cm, lying either way."""
    sizes, _ = sizes_and_pairs(n, 0)
    both = np.stack([sizes, sizes[:, ::-1]], axis=1)
    return SlotOptions(np.zeros(both.shape[:2], dtype=np.int64), both, np.zeros((n, 2)))


@pytest.mark.parametrize("n", [2, 7, 30])
@pytest.mark.parametrize(("name", "family"), FAMILIES)
def test_slots_are_inside_apart_and_large_enough(name: str, family, n: int):
    slot_options, rng = slot_options_for(n), np.random.default_rng(n)
    found = [slots for _ in range(8) if (slots := family(BOX_M, slot_options, GAP_M, rng)) is not None]
    assert found
    for slots in found:
        x0, x1, y0, y1 = slots.T
        assert (x0 >= -0.6 - 1e-9).all()
        assert (x1 <= 0.6 + 1e-9).all()
        assert (y0 >= -0.4 - 1e-9).all()
        assert (y1 <= 0.4 + 1e-9).all()
        size = np.stack([x1 - x0, y1 - y0], axis=1)[:, None]
        if name != "grid":  # rows of random depth: who does not fit changes places later
            assert np.any((slot_options.size_m <= size + 1e-9).all(axis=2), axis=1).all()
        apart = np.maximum(x0[:, None] - x1, y0[:, None] - y1)
        apart = np.maximum(apart, apart.T)[np.triu_indices(n, 1)]
        assert (apart >= GAP_M - 1e-9).all()


def test_guillotine_cuts_find_room_on_a_busy_table():
    """Cuts by the share of areas alone hardly ever left room for 30 boxes."""
    slot_options, rng, guillotine = slot_options_for(30), np.random.default_rng(0), dict(FAMILIES)["guillotine"]
    assert sum(guillotine(BOX_M, slot_options, GAP_M, rng) is not None for _ in range(20)) >= 15


def test_structured_layouts_offer_every_stance():
    """Those beyond the second were never taken."""
    problem = workload(3, 0)
    things = tuple(
        replace(
            thing,
            body=replace(thing.body, resting_orientations=thing.body.resting_orientations * 3)
            if k == 0
            else thing.body,
            domain=Domain(orientation_indices=(0, 1, 2)) if k == 0 else thing.domain,
        )
        for k, thing in enumerate(problem.things)
    )
    names = tuple(thing.name for thing in things)
    model = model_of(replace(problem, things=things))
    pool = pool_model_of(model, names, {}, dict.fromkeys(names, Placement(0.0, 0.0, 0.0, 0)))
    offered = slot_options_of(pool).option
    assert set(pool.members[0].stance[offered[0]].tolist()) == {0, 1, 2}
    assert set(pool.members[1].stance[offered[1]].tolist()) == {0}
