"""The reset functions of the example in the engines they are for."""

import mujoco
import numpy as np

from examples.reset_environments import MujocoReset, parked, slots
from runtime_plan import Plan, prepare
from tests.support.plan.library import tray_plan

TABLE_WB = '<body name="table" pos="0.3 -0.2 0.1" quat="0.968912421710645 0 0 0.247403959254523"><geom {}/></body>'
SHAPES = {
    "table": 'type="box" pos="0 0 0.35" size="0.6 0.4 0.35"',
    "tray": 'type="box" pos="0 0 0.01" size="0.2 0.15 0.01"',
    "cup_a": 'type="box" pos="0 0 0.05" size="0.04 0.03 0.05"',
    "cup_b": 'type="box" pos="0 0 0.06" size="0.03 0.03 0.06"',
    "block": 'type="box" pos="0 0 0.05" size="0.025 0.02 0.05"',
    "plate": 'type="cylinder" pos="0 0 0.015" size="0.1 0.015"',
}


def world(plan: Plan) -> mujoco.MjModel:
    """The table as it stands, and a free body for each slot."""
    free = "".join(
        f'<body name="{thing} {asset}"><freejoint name="{thing} {asset}"/><geom {SHAPES[asset]}/></body>'
        for thing, asset in slots(plan)
    )
    return mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{TABLE_WB.format(SHAPES['table'])}{free}</worldbody></mujoco>"
    )


def test_mujoco_stands_as_the_sample_says_and_what_is_absent_is_out_of_the_way():
    plan = prepare(tray_plan())
    bodies = slots(plan)
    assert bodies == (
        ("tray", "tray"), ("plate", "plate"), ("cup", "cup_a"), ("cup", "cup_b"), ("block", "block"),
    )  # fmt: skip
    model = world(plan)
    data = mujoco.MjData(model)
    addresses = [int(model.joint(f"{thing} {asset}").qposadr[0]) for thing, asset in bodies]
    reset, ids = MujocoReset(plan, 3, addresses), [model.body(f"{thing} {asset}").id for thing, asset in bodies]
    seen = set()
    for _ in range(12):
        mujoco.mj_step(model, data)  # so that there are speeds to be taken away
        drawn = reset(data.qpos, data.qvel)
        mujoco.mj_forward(model, data)
        assert not data.qvel.any()
        there = []
        for slot, (thing, asset) in enumerate(bodies):
            column = drawn.names.index(thing)
            index = int(drawn.asset_index[0, column])
            there.append(index >= 0 and plan.document.bodies[index].asset_id == asset)
            wanted = drawn.position_m[0, column] if there[-1] else parked(slot)
            np.testing.assert_allclose(data.xpos[ids[slot]], wanted, atol=1e-12)
            if there[-1]:
                np.testing.assert_allclose(data.xquat[ids[slot]], drawn.quat_wxyz[0, column], atol=1e-12)
        seen.add(tuple(there))
        waiting = {ids[slot] for slot, here in enumerate(there) if not here}
        assert not waiting & set(model.geom_bodyid[data.contact.geom].ravel().tolist())
        assert not len(data.contact) or data.contact.dist.min() > -1e-6
        before = data.xpos[ids].copy()
        for _ in range(100):
            mujoco.mj_step(model, data)
        assert np.abs(data.xpos[ids] - before)[there].max() < 0.003
    assert {(True, False), (False, True)} == {(there[2], there[3]) for there in seen}  # the cup of both kinds
    assert {True, False} == {there[1] for there in seen}  # with the plate and without
