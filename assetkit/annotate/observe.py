"""Evidence about one canonical object for annotators: names, titles, shape (metres where the unit is known)."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import numpy as np

from assetkit.annotate.annotator import Observation
from assetkit.annotate.shape_check import shape_of
from assetkit.scale.declared_units import is_reliable
from assetkit.stage import Canonical, Draft

_TITLES = ("title", "name")


def observe(draft: Draft) -> Observation:
    """What an annotator sees of a canonical object, but for its pictures."""
    canonical, model = draft[Canonical], draft.model
    paths = [mesh.source_path for mesh in canonical.meshes]
    nodes = (*(part for path in paths for part in PurePosixPath(path).parts), *(mesh.name for mesh in canonical.meshes))
    return Observation(
        file=Path(draft.source_name).stem,
        folders=draft.intake.folders,
        nodes=tuple(dict.fromkeys(name for name in nodes if name.strip("/"))),
        materials=tuple(dict.fromkeys(m.name for m in model.materials if m.name)),
        titles=tuple(model.metadata[key] for key in _TITLES if model.metadata.get(key)),
        shape=shape_of(
            np.concatenate([mesh.points for mesh in canonical.meshes]),
            canonical.solid,
            metric=is_reliable(canonical.meters_per_unit, model.meters_per_unit),
        ),
        shared=draft.intake.siblings > 0,
        articulated=canonical.mechanism is not None,
    )
