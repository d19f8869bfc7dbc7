"""Imports and first uses of what every asset needs, once, before the cells are forked (see `jobs.fork_server`).

The environment variable `MANA_ENGINE` names the engine to import as well (`sim.named_engine`). With `MANA_STUDIO` the
cells that draw pictures find a window with light and shaders ready (`render.ready_studio`).
"""

import contextlib
import importlib
import os
import pkgutil
import sys
import tempfile
from pathlib import Path
from types import ModuleType

# Open3D would load a stack of plotting packages that takes as long as Open3D itself and that nothing here uses.
sys.modules.setdefault("open3d.visualization", ModuleType("open3d.visualization"))

from manifold3d import Manifold  # noqa: E402

import assetkit.pipeline  # noqa: E402
import assetkit.readers  # noqa: E402
import render.views  # noqa: E402, F401
from gate.external_validators import external_verdicts  # noqa: E402
from geom.mesh.surface_distance import NearestOnSurface  # noqa: E402
from jobs.versions import library_versions  # noqa: E402
from render.ready_studio import prepare_studio  # noqa: E402
from render.request import RenderRequest  # noqa: E402
from render.window import NoOpenGL  # noqa: E402
from schemas.files import array_files  # noqa: E402
from sim.named_engine import load_engine  # noqa: E402
from usdio.read.asset import read_stage  # noqa: E402, F401

for _module in pkgutil.walk_packages(assetkit.readers.__path__, "assetkit.readers."):
    importlib.import_module(_module.name)  # Formats load their readers with the first file only.
library_versions()
if engine := os.environ.get("MANA_ENGINE"):
    load_engine(engine)
# Both size their pools of threads with the first work they get; the fork server sees to it that this is one thread.
# More would contend with other cells, and several list the triangles of large hulls in an order of chance.
_ball = Manifold.sphere(1.0, 48).hull().to_mesh64()
NearestOnSurface(_ball.vert_properties[:, :3], _ball.tri_verts)(_ball.vert_properties[:, :3])

for _type in (
    assetkit.pipeline.StoredNotes,
    RenderRequest,
    *(step.stage.result for step in assetkit.pipeline.STAGES.steps),
):
    array_files.adapter(_type)

if os.environ.get("MANA_STUDIO"):
    with contextlib.suppress(NoOpenGL):  # Each cell reports it.
        prepare_studio()

# Validators load most of what they need with the first file that they see.
with tempfile.TemporaryDirectory() as _folder:
    _file = Path(_folder) / "empty" / "empty.usda"
    _file.parent.mkdir()
    _file.write_text("#usda 1.0\n")
    external_verdicts(_file)
