"""A sample of a plan over the scene that was compiled with it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from geom.pose import quat_of
from runtime_plan import Plan, Samples
from runtime_plan.bodies import PhysicalBody, physical_body
from runtime_plan.materials import is_paired, with_material
from runtime_plan.samples_file import sampled_lighting
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.scene.compiled import CompiledScene, Point3, Quat_wxyz
from schemas.scene.geometry import BACKGROUND
from usdio.write.sample import SampleEdit, write_sample

PACKAGES = "packages"


class Layers:
    """Writes samples over the scenes in the folder of a plan; bodies are read once."""

    def __init__(self, plan: Plan, folder: Path) -> None:
        self._plan, self._folder = plan, folder
        self._physical = cache(self._read)
        self._scenes = _scenes(folder)

    def _read(self, index: int) -> PhysicalBody:
        return physical_body(self._plan.document.bodies[index], self._folder / PACKAGES)

    def write(self, samples: Samples, k: int, file: Path) -> Path:
        """Write sample k as `file`. Raises InvalidInput (`plan/missing-file`) where its scene is not there."""
        combination = self._plan.document.combinations[int(samples.combination[k])].combination
        scene = self._scenes.get(frozenset(combination.items()))
        if scene is None or not scene.is_file():
            text = "the scene of the sample (scene.usda and scene.json, or scene-N) is not beside the plan"
            raise InvalidInput(finding("plan/missing-file", text, where=Location(file=str(self._folder))))
        edits = []
        for column in np.flatnonzero(samples.present[k]).tolist():
            x, y, z = samples.position_m[k, column].tolist()
            w, qx, qy, qz = samples.quat_wxyz[k, column].tolist()
            body = int(samples.asset_index[k, column])
            edits.append(
                self._edit(samples.names[column], body, int(samples.material[k, column]), (x, y, z), (w, qx, qy, qz))
            )
        there = set(np.array(samples.names)[samples.present[k]].tolist())
        named = {thing.id for thing in self._plan.document.combinations[int(samples.combination[k])].objects}
        edits += [SampleEdit(name, is_absent=True) for name in sorted(named - there)]
        if samples.rise_m[k] > 0.0:
            edits.append(self._raised(samples, k))
        if samples.background[k] >= 0 and samples.background_material[k] >= 0:
            edits.append(self._edit(BACKGROUND, int(samples.background[k]), int(samples.background_material[k])))
        lighting = sampled_lighting(self._plan, samples, k)
        return write_sample(scene, edits, lighting, self._folder / PACKAGES, file)

    def _raised(self, samples: Samples, k: int) -> SampleEdit:
        """The background at the height of sample k."""
        X_WB = np.array(self._plan.document.combinations[int(samples.combination[k])].X_WB)
        w, qx, qy, qz = (float(q) for q in quat_of(X_WB[:3, :3]))
        x, y, z = (float(v) for v in X_WB[:3, 3])
        return SampleEdit(BACKGROUND, (x, y, z + float(samples.rise_m[k])), (w, qx, qy, qz))

    def _edit(
        self, name: str, body: int, material: int, at: Point3 | None = None, quat: Quat_wxyz | None = None
    ) -> SampleEdit:
        package = self._plan.document.bodies[body].package if at is not None else None
        if material < 0:
            return SampleEdit(name, at, quat, package)
        own, worn = self._physical(body), self._plan.document.materials[material]
        dressed = with_material(own.body, own.density_kgm3, worn)
        density_factor = dressed.mass.mass_kg / own.body.mass.mass_kg if at is not None else 1.0
        return SampleEdit(name, at, quat, package, worn, dressed.contact if is_paired(worn) else None, density_factor)


def _scenes(folder: Path) -> dict[frozenset[tuple[str, str]], Path]:
    """Stages by their combination: a restricted plan counts its combinations anew."""
    files = {}
    for said in sorted(folder.glob("scene*.json")):
        scene = CompiledScene.model_validate_json(said.read_bytes())
        files[frozenset(scene.combination.items())] = said.with_suffix(".usda")
    return files
