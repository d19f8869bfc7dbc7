"""Real and generated objects, and their packages as the pipeline releases them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh
from trimesh import creation

from assetkit.batch.item_cells import ENVIRONMENT, PRELOAD
from assetkit.options import Options
from assetkit.pipeline import process_source
from assetkit.sources.discover import SourceAsset
from jobs.warm import warm_cells
from sim.bullet.simulator import BulletSimulator

# Of the packages that tests share: a round body, a cavity with a handle, a JPEG texture.
MADE = ("duck", "mug", "domino")
# Of pybullet_data: a convex scan.
INSTALLED = ("random_urdfs/009/009.obj",)
# Of the shared assets: small and large, thin and round, polyhedral and curved.
SHARED = (
    "stl/tm_20mm-xyz-cube_stl/20mm-xyz-cube.stl",
    "obj/ycb_016_pear_vhacd/collision_vhacd.obj",
    "obj/tm_fuze_obj/fuze.obj",
    "glb/habitat_chair_glb/chair.glb",
    "malformed/ply/gen_hollow_sphere/part.ply",
)


def generated() -> dict[str, trimesh.Trimesh]:
    """Shapes whose poses one can name, by asset id; metres."""
    corners = np.array([(x, y, z) for y, z in ((0.0, 0.0), (0.1, 0.0), (0.0, 0.06)) for x in (0.0, 0.08)])
    leg = creation.box((0.03, 0.09, 0.05)).apply_translation((0.015, 0.045, 0.025))
    return {
        "angle": creation.box((0.12, 0.03, 0.05)).apply_translation((0.06, 0.015, 0.025)).union(leg),
        "wedge": trimesh.convex.convex_hull(corners),
        "can": creation.cylinder(0.033, 0.1, sections=64),
        "pill": creation.capsule(0.08, 0.02),
        "ball": creation.icosphere(4, 0.03),
        "cone": creation.cone(0.04, 0.09, sections=48),
    }


def labelled_plank() -> trimesh.Scene:
    """A plank with a flat label, a visible mesh without volume, 0.2 mm above its face."""
    corners = [[-0.1, -0.03, 0.0052], [0.1, -0.03, 0.0052], [0.1, 0.03, 0.0052], [-0.1, 0.03, 0.0052]]
    label = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    return trimesh.Scene({"plank": creation.box((0.3, 0.08, 0.01)), "label": label})


def write_generated(folder: Path) -> list[Path]:
    """The generated shapes as PLY files in `folder`, the plank as GLB."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {folder / f"{name}.ply": mesh for name, mesh in generated().items()}
    for file, mesh in files.items():
        mesh.export(file)
    plank = folder / "plank.glb"
    labelled_plank().export(plank)
    return [*files, plank]


def release(candidates: Sequence[SourceAsset], out: Path) -> list[Path]:
    """The package folders made of `candidates` in `out`, with warm cells; AssertionError unless each gives one."""
    packages: list[Path] = []
    with warm_cells(PRELOAD, env=ENVIRONMENT), BulletSimulator() as simulator:
        for candidate in candidates:
            work = out / ".work" / candidate.asset_id
            item = process_source(candidate, options=Options(), simulator=simulator, out=out, work_dir=work, fresh=True)
            assert item.packages, f"{candidate.given}: {item.outcome.value}, {item.codes}, {item.traceback}"
            packages += [out / name for name in item.packages]
    return packages
