"""Samples drawn by PyTorch and resets as Isaac Lab calls them, in an interpreter that has PyTorch; results are arrays.

`make peers` makes that interpreter (`tools/torch-environment.sh`). As a script: `torch_draws.py FOLDER` answers each
`NAME.json` (a plan) with `NAME.npz`.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.support.peers import ROOT, peer_python

SEED, START, COUNT = 2**63 + 5, 70, 1000
ENVIRONMENTS, ENDED = 8, [1, 3, 6]  # those that are reset after all were


def answered(folder: Path) -> None:
    """Has every plan of a folder answered."""
    command = [str(peer_python("torch")), "-m", "tests.support.plan.torch_draws", str(folder)]
    path = {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, cwd=ROOT,
                          env={**os.environ, **path})  # fmt: skip
    assert done.returncode == 0, done.stderr


class RigidObject:
    """What Isaac Lab 2 documents of `isaaclab.assets.RigidObject`, as far as a reset needs it."""

    def __init__(self, torch: Any) -> None:
        self._torch = torch
        state = torch.zeros(ENVIRONMENTS, 13)
        state[:, 3] = 1.0
        self.data = SimpleNamespace(default_root_state=state)
        self.pose, self.velocity = torch.full((ENVIRONMENTS, 7), torch.nan), torch.ones(ENVIRONMENTS, 6)

    def write_root_pose_to_sim(self, root_pose: Any, env_ids: Any) -> None:
        """Poses (len(env_ids), 7) in the simulation frame, quaternion wxyz; 32-bit floats, as its buffers are."""
        assert root_pose.shape == (len(env_ids), 7)
        assert root_pose.dtype == self._torch.float32
        assert bool((self._torch.linalg.norm(root_pose[:, 3:], dim=1) - 1.0).abs().max() < 1e-6)
        self.pose[env_ids] = root_pose.clone()

    def write_root_velocity_to_sim(self, root_velocity: Any, env_ids: Any) -> None:
        """Linear and angular velocities (len(env_ids), 6)."""
        assert root_velocity.shape == (len(env_ids), 6)
        assert root_velocity.dtype == self._torch.float32
        self.velocity[env_ids] = root_velocity.clone()


class Scene(dict[str, RigidObject]):
    """What Isaac Lab 2 documents of `isaaclab.scene.InteractiveScene`: assets by key, and `env_origins` (n, 3)."""

    env_origins: Any


def _answer(file: Path) -> None:
    import torch

    from examples.reset_environments import IsaacLabReset, slots
    from runtime_plan import load
    from runtime_plan.torch_sampler import TorchSampler

    plan = load(file)
    sampler = TorchSampler(plan)
    samples = sampler.sample(COUNT, SEED, start=START)
    arrays = {f.name: getattr(samples, f.name) for f in fields(samples) if f.name not in ("seed", "start", "names")}

    bodies = slots(plan)
    assets = tuple(f"{thing}_as_{asset}" for thing, asset in bodies)
    scene = Scene({asset: RigidObject(torch) for asset in assets})
    scene.env_origins = torch.arange(3 * ENVIRONMENTS, dtype=torch.float32).reshape(-1, 3)
    env, reset = SimpleNamespace(scene=scene), IsaacLabReset(plan, sampler, assets, SEED)
    for env_ids in (torch.arange(ENVIRONMENTS), torch.tensor(ENDED)):
        reset(env, env_ids)
    arrays["root_pose"] = torch.stack([scene[asset].pose for asset in assets])
    arrays["root_velocity"] = torch.stack([scene[asset].velocity for asset in assets])
    arrays["env_origins"] = scene.env_origins
    np.savez(file.with_suffix(".npz"), **{name: value.numpy() for name, value in arrays.items()})


if __name__ == "__main__":
    for found in sorted(Path(sys.argv[1]).glob("*.json")):
        _answer(found)
