"""A sample of a plan over the scene that was compiled with it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from runtime_plan import Plan, Samples, as_document
from runtime_plan.bodies import PhysicalBody, physical_body
from runtime_plan.materials import is_paired, wearing
from schemas.compiled_scene import Point3, Quat_wxyz
from schemas.diagnostics import InvalidInput, Location, finding
from usdio.write_sample import SampleEdit, write_sample

PACKAGES, BACKGROUND = "packages", "background"


class Layers:
    """Writes samples over the scenes in the folder of a plan; bodies are read once."""

    def __init__(self, plan: Plan, folder: Path) -> None:
        self._plan, self._folder = plan, folder
        self._physical = cache(self._read)

    def _read(self, index: int) -> PhysicalBody:
        return physical_body(self._plan.document.bodies[index], self._folder / PACKAGES)

    def write(self, samples: Samples, k: int, file: Path) -> Path:
        """Write sample k as `file`. Raises InvalidInput (`plan/missing-file`) where its scene is not there."""
        combination = int(samples.combination[k])
        scene = self._folder / ("scene.usda" if combination == 0 else f"scene-{combination + 1}.usda")
        if not scene.is_file():
            text = f"{scene.name} of the sample is not beside the plan"
            raise InvalidInput(finding("plan/missing-file", text, where=Location(file=scene.name)))
        edits = []
        for column in np.flatnonzero(samples.present[k]).tolist():
            x, y, z = samples.position_m[k, column].tolist()
            w, qx, qy, qz = samples.quat_wxyz[k, column].tolist()
            body = int(samples.asset_index[k, column])
            edits.append(
                self._edit(samples.names[column], body, int(samples.material[k, column]), (x, y, z), (w, qx, qy, qz))
            )
        if samples.background[k] >= 0 and samples.background_material[k] >= 0:
            edits.append(self._edit(BACKGROUND, int(samples.background[k]), int(samples.background_material[k])))
        lighting = as_document(self._plan, samples).samples[k].lighting
        return write_sample(scene, edits, lighting, self._folder / PACKAGES, file)

    def _edit(
        self, name: str, body: int, material: int, at: Point3 | None = None, quat: Quat_wxyz | None = None
    ) -> SampleEdit:
        package = self._plan.document.bodies[body].package if at is not None else None
        if material < 0:
            return SampleEdit(name, at, quat, package)
        own, worn = self._physical(body), self._plan.document.materials[material]
        made = wearing(own.body, own.density_kgm3, worn)
        denser = made.mass.mass_kg / own.body.mass.mass_kg if at is not None else 1.0
        return SampleEdit(name, at, quat, package, worn, made.contact if is_paired(worn) else None, denser)
