"""Retopology, the stage between intake and canonicalize: a light mesh with baked maps, where the options want one."""

from __future__ import annotations

from assetkit.options import Options
from assetkit.retopo.retopologize import MAP_PX, retopologize
from assetkit.stage import Draft, Retopology, Stage, Tools
from schemas.outcome import Outcome


class Retopologize(Stage):
    """Replaces heavy meshes by light ones that look alike, in the units and axes of the source."""

    name = "retopology"
    version = 2
    result = Retopology

    def wanted(self, options: Options) -> bool:
        """Whether the options state a number of faces."""
        return options.retopo is not None

    def run(self, draft: Draft, tools: Tools) -> Outcome[Retopology]:
        """Meshes, materials and textures to go on with, and the figures of the comparison."""
        model, options = draft.intake.model, tools.options
        if options.retopo is None:
            return Outcome(Retopology(model.meshes, model.materials, model.textures))
        return retopologize(model, options.retopo, min(MAP_PX, options.max_texture or MAP_PX), tools.work_dir)
