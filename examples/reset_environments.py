"""Reset functions of simulators fed by a plan: the whole adapter is a copy of arrays.

    python -m examples.reset_environments plan.json

The two classes below are what a task in MuJoCo or Isaac Lab calls when episodes end. Neither is imported here;
`main` runs the first on plain arrays.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

import runtime_plan
from runtime_plan import Plan, Samples


class MujocoReset:
    """For MuJoCo: every thing is a body with a free joint; `addresses` are their `jnt_qposadr`, in order of `names`.

    MuJoCo's free joint takes x, y, z and a quaternion wxyz, which is what samples hold.
    """

    def __init__(self, plan: Plan, seed: int, addresses: list[int]) -> None:
        self.plan, self.seed, self.addresses, self.episode = plan, seed, addresses, 0

    def __call__(self, qpos: np.ndarray, qvel: np.ndarray) -> Samples:
        """Write the next scene into `data.qpos`; returns the sample, for materials and lighting."""
        drawn = runtime_plan.sample(self.plan, 1, self.seed, start=self.episode)
        self.episode += 1
        for column, address in enumerate(self.addresses):
            if drawn.present[0, column]:
                qpos[address : address + 3] = drawn.position_m[0, column]
                qpos[address + 3 : address + 7] = drawn.quat_wxyz[0, column]
        qvel[:] = 0.0
        return drawn


class IsaacLabReset:
    """For Isaac Lab: an event term of mode `reset`. `sampler` is a `runtime_plan.torch_sampler.TorchSampler`.

    Isaac Lab's root state is x, y, z, quaternion wxyz, then velocities; origins of environments are added.
    """

    def __init__(self, sampler: Any, names: tuple[str, ...], seed: int) -> None:
        self.sampler, self.names, self.seed, self.drawn = sampler, names, seed, 0

    def __call__(self, env: Any, env_ids: Any) -> None:
        """Draw one scene for each environment that ended and write root poses; nothing leaves the device."""
        scenes = self.sampler.sample(len(env_ids), self.seed, start=self.drawn)
        self.drawn += len(env_ids)
        for column, name in enumerate(self.names):
            state = env.scene[name].data.default_root_state[env_ids].clone()
            state[:, 0:3] = scenes.position_m[:, column] + env.scene.env_origins[env_ids]
            state[:, 3:7] = scenes.quat_wxyz[:, column]
            state[:, 7:] = 0.0
            env.scene[name].write_root_state_to_sim(state, env_ids)


def main(path: str) -> None:
    """Two resets of the plan in `path`, printed."""
    plan = runtime_plan.load(path)
    names = plan.tables.names
    reset = MujocoReset(plan, seed=0, addresses=[7 * column for column in range(len(names))])
    qpos, qvel = np.zeros(7 * len(names)), np.zeros(6 * len(names))
    for _ in range(2):
        drawn = reset(qpos, qvel)
        print({name: qpos[7 * k : 7 * k + 3].round(3).tolist() for k, name in enumerate(names) if drawn.present[0, k]})


if __name__ == "__main__":
    main(sys.argv[1])
