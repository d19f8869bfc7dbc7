"""Stage 1, intake: one source file into objects, each with its model, screened for what cannot become an asset.

Intake comes before there is a draft: it takes a source asset and gives any number of objects. So its `accepts` and
`run` have the meaning of `assetkit.stage.Stage`, but other arguments.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from assetkit.options import Options
from assetkit.readers.by_format import READERS
from assetkit.sources.discover import SourceAsset
from assetkit.sources.screening import file_findings, require_surface, several_objects
from assetkit.sources.sibling_files import sibling_statements
from assetkit.sources.split_objects import split_objects
from assetkit.stage import Intake, IntakeResult
from schemas.diagnostics import Diagnostic, InvalidInput


class ReadSource:
    """Reads a source file with the reader of its format and splits the model into far-apart objects."""

    name = "intake"
    version = 6
    result = IntakeResult

    def accepts(self, asset: SourceAsset) -> list[Diagnostic]:
        """Why the file cannot be read at all; the first reason only."""
        return file_findings(asset, READERS)

    def run(self, asset: SourceAsset, options: Options) -> IntakeResult:
        """The objects of the source; fatal findings come back as error diagnostics and no objects."""
        try:
            refused = self.accepts(asset)
            return IntakeResult((), tuple(refused), (), review=False) if refused else self._read(asset, options)
        except InvalidInput as refused:
            return IntakeResult((), (refused.diagnostic,), (), review=False)

    def _read(self, asset: SourceAsset, options: Options) -> IntakeResult:
        outcome = READERS[asset.format](asset.file)
        diagnostics = list(outcome.diagnostics)
        if outcome.value is None or outcome.failed:
            return IntakeResult((), tuple(diagnostics), outcome.repairs, review=False)
        siblings = sibling_statements(asset.file) if outcome.value.meters_per_unit.source == "default" else ()
        model = replace(
            outcome.value,
            meshes=tuple(m for m in outcome.value.meshes if len(m.triangles)),
            hints=(*outcome.value.hints, *siblings),
            metadata={**outcome.value.metadata, **options.provenance()},
        )
        require_surface(model)
        files = asset.file.files_read()
        models = tuple(m.with_mesh_ids() for m in (split_objects(model) if model.mechanism is None else (model,)))
        review = any(d.code == "asset/articulated-source" for d in diagnostics)
        if len(models) > 1:
            too_many = len(models) > options.max_objects
            diagnostics.append(several_objects(len(models), options.max_objects, too_many=too_many))
            if too_many:
                models, review = (model.with_mesh_ids(),), True
        low, high = (f([f(m.points, axis=0) for m in model.meshes], axis=0) for f in (np.min, np.max))
        extent = (float(high[0] - low[0]), float(high[1] - low[1]), float(high[2] - low[2]))
        folders = asset.file.folder_names()
        objects = tuple(Intake(asset.format, files, m, extent, folders[0], folders, len(models) - 1) for m in models)
        return IntakeResult(objects, tuple(diagnostics), outcome.repairs, review)
