"""Reset functions of simulators fed by a plan: the whole adapter is a copy of arrays.

    python -m examples.reset_environments plan.json

The two classes below are what a task in MuJoCo or Isaac Lab calls when episodes end. Neither is imported here;
`main` runs the first on plain arrays.

A simulator builds its bodies once. So its scene holds one body for each of `slots`, and a reset puts those that a
sample does not have far beside the scene: what may be a mug or a bowl is two bodies, of which one is parked.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

import runtime_plan
from runtime_plan import Plan, Samples

PARKED_M, STEP_M = (1000.0, 0.0, 1.0), 10.0  # the first parked body; each further one is a step along x beyond
UPRIGHT_WXYZ = (1.0, 0.0, 0.0, 0.0)
Slot = tuple[str, str]  # a thing of the plan and one of the assets that it may be


def slots(plan: Plan) -> tuple[Slot, ...]:
    """The bodies that a simulator must hold for a plan, in the order in which the resets below take them."""
    return tuple((name, plan.document.bodies[body].asset_id) for name, body in _numbered(plan))


def _numbered(plan: Plan) -> list[tuple[str, int]]:
    """(thing, number of a body), things in the order of `Samples.names`."""
    names = plan.tables.names
    found = {(t.id, body) for one in plan.document.combinations for t in one.objects for body in t.bodies}
    return sorted(found, key=lambda slot: (names.index(slot[0]), slot[1]))


def parked(slot: int) -> tuple[float, float, float]:
    """Where the body of a slot waits, in the frame of the scene: it meets nothing, and falls if there is no ground."""
    return PARKED_M[0] + STEP_M * slot, PARKED_M[1], PARKED_M[2]


class MujocoReset:
    """For MuJoCo: every slot is a body with a free joint; `addresses` are their `jnt_qposadr`, in the order of `slots`.

    MuJoCo's free joint takes x, y, z and a quaternion wxyz, which is what samples hold.
    """

    def __init__(self, plan: Plan, seed: int, addresses: list[int]) -> None:
        self.plan, self.seed, self.addresses, self.episode = plan, seed, addresses, 0
        self._numbered = _numbered(plan)

    def __call__(self, qpos: np.ndarray, qvel: np.ndarray) -> Samples:
        """Write the next scene into `data.qpos`, at rest; returns the sample, for materials and lighting."""
        drawn = runtime_plan.sample(self.plan, 1, self.seed, start=self.episode)
        self.episode += 1
        for slot, ((name, body), address) in enumerate(zip(self._numbered, self.addresses, strict=True)):
            column = drawn.names.index(name)
            there = drawn.asset_index[0, column] == body
            qpos[address : address + 3] = drawn.position_m[0, column] if there else parked(slot)
            qpos[address + 3 : address + 7] = drawn.quat_wxyz[0, column] if there else UPRIGHT_WXYZ
        qvel[:] = 0.0
        return drawn


class IsaacLabReset:
    """For Isaac Lab 2: an event term of mode `reset`. `sampler` is a `runtime_plan.torch_sampler.TorchSampler` of the
    plan, `assets` are the keys of the rigid objects in `env.scene`, in the order of `slots`.

    Its root poses are x, y, z and a quaternion wxyz in the world, so origins of environments are added. (Isaac Lab 3
    takes xyzw.)
    """

    def __init__(self, plan: Plan, sampler: Any, assets: tuple[str, ...], seed: int) -> None:
        self.sampler, self.assets, self.seed, self.drawn = sampler, assets, seed, 0
        self._numbered = _numbered(plan)

    def __call__(self, env: Any, env_ids: Any) -> None:
        """Draw one scene for each environment that ended and write root poses, at rest; nothing leaves the device."""
        scenes = self.sampler.sample(len(env_ids), self.seed, start=self.drawn)
        self.drawn += len(env_ids)
        origins = env.scene.env_origins[env_ids]
        for slot, ((name, body), asset) in enumerate(zip(self._numbered, self.assets, strict=True)):
            column = scenes.names.index(name)
            there = (scenes.asset_index[:, column] == body)[:, None]
            state = env.scene[asset].data.default_root_state[env_ids].clone()
            waits = state.new_tensor((*parked(slot), *UPRIGHT_WXYZ))
            state[:, 0:3] = scenes.position_m[:, column].where(there, waits[0:3].double()) + origins
            state[:, 3:7] = scenes.quat_wxyz[:, column].where(there, waits[3:7].double())
            state[:, 7:] = 0.0
            env.scene[asset].write_root_pose_to_sim(state[:, 0:7], env_ids)
            env.scene[asset].write_root_velocity_to_sim(state[:, 7:], env_ids)


def main(path: str) -> None:
    """Two resets of the plan in `path`, printed."""
    plan = runtime_plan.load(path)
    bodies = slots(plan)
    reset = MujocoReset(plan, seed=0, addresses=[7 * slot for slot in range(len(bodies))])
    qpos, qvel = np.zeros(7 * len(bodies)), np.zeros(6 * len(bodies))
    for _ in range(2):
        reset(qpos, qvel)
        print(
            {f"{thing} ({asset})": qpos[7 * k : 7 * k + 3].round(3).tolist() for k, (thing, asset) in enumerate(bodies)}
        )


if __name__ == "__main__":
    main(sys.argv[1])
