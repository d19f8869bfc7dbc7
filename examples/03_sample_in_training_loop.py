"""Scenes for the resets of a training loop: `runtime_plan.load` and `runtime_plan.sample`.

    python examples/03_sample_in_training_loop.py OUT    (after 02_compile.py)

A reset draws one scene for each environment whose episode ended: arrays of poses, valid by construction, without any
search. Scene k of a seed is always the same, whatever the batches, so a counter is all the state that a run must save.
`examples/reset_environments.py` writes such arrays into MuJoCo and Isaac Lab.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import runtime_plan

ENVIRONMENTS, EPISODES, SEED = 256, 1024, 7


class Resets:
    """The reset function of a training loop; `drawn` scenes of the stream `seed` are used."""

    def __init__(self, plan: runtime_plan.Plan, seed: int, drawn: int = 0) -> None:
        self.plan, self.seed, self.drawn = plan, seed, drawn

    def __call__(self, env_ids: np.ndarray) -> runtime_plan.Samples:
        """One new scene for each environment; row i of the arrays belongs to `env_ids[i]`."""
        scenes = runtime_plan.sample(self.plan, len(env_ids), self.seed, start=self.drawn)
        self.drawn += len(env_ids)
        return scenes


def main(out: Path) -> None:
    """Run a loop in which episodes end at random; print how widely objects were spread over the environments."""
    plan = runtime_plan.load(out / "scene" / "plan.json", packages=out / "library")  # refuses packages that changed
    reset, rng = Resets(plan, SEED), np.random.default_rng(0)
    position_m = np.zeros((ENVIRONMENTS, len(plan.tables.names), 3))
    env_ids = np.arange(ENVIRONMENTS)
    while reset.drawn < EPISODES:
        scenes = reset(env_ids)
        position_m[env_ids] = scenes.position_m  # here a simulator sets the poses of its bodies
        env_ids = np.flatnonzero(rng.random(ENVIRONMENTS) < 0.2)  # here the policy acts until some episodes end
    for name, low_m, high_m in zip(plan.tables.names, position_m.min(axis=0), position_m.max(axis=0), strict=True):
        print(f"{name}: x from {low_m[0]:.3f} to {high_m[0]:.3f} m, y from {low_m[1]:.3f} to {high_m[1]:.3f} m")
    print(f"{reset.drawn} scenes drawn; the next run goes on with Resets(plan, {SEED}, drawn={reset.drawn})")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
