"""Samples of a plan as arrays, one row per sample: choices as indices, poses in the world frame (m, wxyz)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Array = Any  # an array of the chosen library: numpy by default


@dataclass(frozen=True)
class Samples:
    """n samples of a plan with N things in all; sample k has the index `start + k`.

    names         N, the columns below; `present` (n, N) whether a sample has them
    combination   (n,) index into the plan's; `case` (n, P) the case of each of its pools, -1 beyond them
    asset_index   (n, N) into the plan's bodies, -1 where absent; `stance` (n, N) into the body's, 0 where absent
    support       (n, N) column of the owner, -1 for the background, -2 where absent
    position_m    (n, N, 3) of the asset frame in W, NaN where absent; `quat_wxyz` (n, N, 4) likewise
    yaw_rad       (n, N) as drawn, in the frame of the owner
    material      (n, N) into the plan's materials, -1 as authored; `background_material` (n,) likewise
    background    (n,) into the plan's bodies, -1 for none
    lighting      (n,) into the plan's lighting, -1 for none; `channels` (n, 4) its intensity, exposure, temperature (K)
                  and rotation (rad), NaN where it leaves one alone
    rise_m        (n,) height of the background over its lowest one; positions count it in
    """

    seed: int
    start: int
    names: tuple[str, ...]
    combination: Array
    case: Array
    present: Array
    asset_index: Array
    stance: Array
    support: Array
    position_m: Array
    quat_wxyz: Array
    yaw_rad: Array
    material: Array
    background_material: Array
    background: Array
    lighting: Array
    channels: Array
    rise_m: Array

    def __len__(self) -> int:
        return len(self.combination)
