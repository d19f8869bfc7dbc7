"""Realise samples in a simulator: build each body once, then set poses (W, m) and materials at each reset."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geom.pose import pose_from_quat
from runtime_plan.bodies import PhysicalBody, physical_body
from runtime_plan.materials import with_material
from runtime_plan.plan import Plan
from runtime_plan.samples import Samples
from schemas.scene.geometry import BACKGROUND
from schemas.scene.program import PairedMaterial
from sim.port import ResetWorld

Slot = tuple[str, int]  # a thing (or the background) and one of its bodies


class Realiser:
    """The bodies of a plan in one simulated world. A body is built when a sample first needs it, and never again."""

    def __init__(self, plan: Plan, packages: Path | None, world: ResetWorld) -> None:
        self._plan, self._packages, self._world = plan, packages, world
        self._physical: dict[int, PhysicalBody] = {}
        self._number: dict[Slot, int] = {}
        self._material_of: dict[Slot, int] = {}
        self._placed: set[Slot] = set()

    def reset(self, samples: Samples, k: int) -> dict[str, int]:
        """Set the world to sample k; returns the number in the world of each thing that is present.

        Bodies that the sample lacks are parked. A material sets mass, inertia and contact in one call.
        """
        used: dict[Slot, tuple[np.ndarray, int, bool]] = {}
        background = int(samples.background[k])
        if background >= 0:
            combination = self._plan.document.combinations[int(samples.combination[k])]
            X_WB = np.array(combination.X_WB)
            X_WB[2, 3] += samples.rise_m[k]
            used[BACKGROUND, background] = X_WB, int(samples.background_material[k]), False
        for column in np.flatnonzero(samples.present[k]).tolist():
            X_WA = pose_from_quat(samples.quat_wxyz[k, column], samples.position_m[k, column])
            slot = samples.names[column], int(samples.asset_index[k, column])
            used[slot] = X_WA, int(samples.material[k, column]), True
        for slot in sorted(self._placed - set(used)):
            self._world.set_pose(self._number[slot], None)
        for slot, (slot_X_WA, material, moves) in used.items():
            self._build(slot, material, moves)
            self._world.set_pose(self._number[slot], slot_X_WA)
        self._placed = set(used)
        return {name: self._number[name, body] for name, body in used if name != BACKGROUND}

    def _build(self, slot: Slot, material: int, moves: bool) -> None:
        """Build the body of a slot if there is none, and set its material if it has another one."""
        if self._material_of.get(slot) == material:
            return
        index = slot[1]
        if index not in self._physical:
            self._physical[index] = physical_body(self._plan.document.bodies[index], self._packages)
        physical = self._physical[index]
        paired: PairedMaterial | None = self._plan.document.materials[material] if material >= 0 else None
        body = with_material(physical.body, physical.density_kgm3, paired)
        if slot not in self._number:
            self._number[slot] = self._world.add(physical.body, moves)
        self._material_of.pop(slot, None)  # Where the next call fails, the next reset sets the material again.
        self._world.set_material(self._number[slot], body.mass, body.contact)
        self._material_of[slot] = material
