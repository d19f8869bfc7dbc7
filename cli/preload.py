"""What every asset needs: imported once, before the cells are forked (see `jobs.fork_server`)."""

import open3d  # noqa: F401  (`geom` loads it late, because callers without meshes do not need it)

import assetkit.pipeline  # noqa: F401
import render.views  # noqa: F401
import sim.bullet  # noqa: F401
from usdio.outside import simready_rules

simready_rules()
