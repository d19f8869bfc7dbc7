"""How light meshes with baked maps differ from heavy ones: silhouettes, colours, every map; processor seconds.

    python -m benchmarks.assets.retopo ASSETS_DIR [--only TEXT] [--faces N] [--pictures DIR] [--simplifiers]

No development asset has 200,000 triangles, so textured ones are cut finer until they have, and once more with ripples
along their normals that N triangles cannot hold (`heavy_scans`). `mikktspace` is the angle between normals shaded in
the frame that the map was baked for and those of a renderer that averages tangents at corners. With `--simplifiers`
three ways to N triangles are compared instead. The process and its children run on one core.
"""

from __future__ import annotations

import argparse
import io
import os
import resource
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import fast_simplification
import numpy as np
from PIL import Image
from pymeshlab.pmeshlab import Mesh as LabMesh
from pymeshlab.pmeshlab import MeshSet

from assetkit.package.preview_images import render_views
from assetkit.pose.up_axis import TO_Z_UP
from assetkit.retopo import remesh_worker
from assetkit.retopo import retopologize as judged
from assetkit.retopo.fidelity import silhouette
from assetkit.retopo.surface_values import NORMAL_FIELD, Surface, surfaces_of, unit
from assetkit.stage import Retopology
from benchmarks.assets.heavy_scans import heavy, read_model
from geom.mesh.corner_normals import face_normals
from geom.mesh.rays import Rays
from geom.mesh.surface_distance import sample_surface, two_way_distance
from geom.mesh.tangent_frames import out_of_frame, tangent_frames
from geom.mesh.weld import weld_points
from render.camera import STANDARD_VIEWS, annotation_frame
from schemas.arrays import FloatArray, IntArray
from schemas.model import Mesh, Model

ASSETS = (
    "obj/hope_ketchup_obj_cm/textured.obj",
    "obj/gso_frypan_obj/chefmate_8_frypan.obj",
    "glb/k3dc_mixer_glb/Mixer.glb",
    "gltf/ph_sofa_03/sofa_03_1k.gltf",
    "gltf/ph_painted_wooden_stool/painted_wooden_stool_1k.gltf",
    "gltf/ph_painted_wooden_cabinet_02/painted_wooden_cabinet_02_1k.gltf",
)
LEAST_TRIANGLES = 200_000
SAMPLES = 20_000
Surfaces = tuple[FloatArray, IntArray]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("assets", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--faces", type=int, default=5000)
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--simplifiers", action="store_true")
    options = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    judged.LEAST_IOU, judged.MOST_COLOUR_ERROR_255 = 0.0, np.inf  # figures of results that would be dropped, too
    for name in (name for name in ASSETS if options.only in name):
        source = read_model(options.assets / name)
        for rippled in (False, True):
            scan = heavy(source, LEAST_TRIANGLES, rippled=rippled)
            label = f"{Path(name).parent.name}{' rippled' if rippled else ''}"
            if options.simplifiers:
                _print_simplifiers(label, scan, options.faces)
            else:
                _print_row(label, scan, options.faces, options.pictures)


def _print_row(label: str, scan: Model, faces: int, pictures: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        started = _cpu_s()
        outcome = judged.retopologize(scan, faces, judged.MAP_PX, Path(folder))
        seconds = _cpu_s() - started
        light = outcome.value
        if light is None or light.section is None:
            print(f"| {label} | {outcome.diagnostics[0].headline} |")
            return
        if pictures is not None:
            _draw(scan, light, Path(folder), pictures / f"{label}.png")
    section = light.section
    maps = "; ".join(f"{name} {error.mean.value:.2f} ({error.p95:.2f})" for name, error in section.maps.items())
    frames = mikktspace_degrees(_model_of(scan, light))
    print(
        f"| {label} | {section.triangles_before} | {section.triangles_after} | {section.silhouette_iou.value:.4f} | "
        f"{section.colour_error_255.value:.2f} | {maps} | {frames:.2f} | {section.texels_by_ray:.3f} | {seconds:.0f} |",
        flush=True,
    )


def _cpu_s() -> float:
    """Processor time of this process and of its ended children, s."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _model_of(scan: Model, light: Retopology) -> Model:
    return replace(scan, meshes=light.meshes, materials=light.materials, textures=light.textures)


def _draw(scan: Model, light: Retopology, folder: Path, target: Path) -> None:
    """The standard views of the source above those of the result."""
    upright = [_upright(model) for model in (scan, _model_of(scan, light))]
    points = np.concatenate([mesh.points for mesh in upright[0].meshes])
    box = points.min(axis=0), points.max(axis=0)
    rows = [
        np.concatenate([np.asarray(Image.open(io.BytesIO(p)).convert("RGB")) for p in views.values()], axis=1)
        for views in (render_views(model, box, folder) for model in upright)
    ]
    target.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.concatenate(rows)).save(target)


def _upright(model: Model) -> Model:
    R = TO_Z_UP[model.up_axis.value]
    turned = (
        replace(m, points=m.points @ R.T, normals=None if m.normals is None else (m.normals @ R.T).astype(np.float32))
        for m in model.meshes
    )
    return replace(model, meshes=tuple(turned))


def mikktspace_degrees(model: Model) -> float:
    """The mean angle (degrees) over the surface between normals in the baked frame and with averaged tangents."""
    surfaces = surfaces_of(model, model.meshes)
    angles = [_frame_angles(surface) for surface in surfaces if NORMAL_FIELD in surface.pictures]
    return float(np.concatenate(angles).mean()) if angles else 0.0


def _frame_angles(surface: Surface) -> FloatArray:
    mesh = surface.mesh
    points, _ = sample_surface(mesh.points, mesh.triangles, SAMPLES, 0)
    faces, weights, _ = Rays(mesh.points, mesh.triangles).nearest(points)
    smooth = unit(np.einsum("kc,kcx->kx", weights, surface.normals[faces]))
    frames = tangent_frames(mesh.points, mesh.triangles, mesh.uvs[0])
    baked = surface.shaded_normals(faces, weights)
    T = unit(frames.tangents - np.einsum("mi,mi->m", frames.tangents, _flat(mesh))[:, None] * _flat(mesh))
    averaged = np.einsum("kc,kcx->kx", weights, corner_tangents(mesh, surface.normals, T)[faces])
    tilt = bare_tilt(surface, faces, weights)
    other = unit(out_of_frame(tilt, smooth, averaged, frames.sides[faces]))
    return np.degrees(np.arccos(np.clip(np.einsum("ki,ki->k", baked, other), -1.0, 1.0)))


def _flat(mesh: Mesh) -> FloatArray:
    return face_normals(mesh.points, mesh.triangles).astype(np.float64)


def bare_tilt(surface: Surface, faces: IntArray, weights: FloatArray) -> FloatArray:
    """(k, 3) components of the normal map: its normals where the frame is that of the axes."""
    count = len(surface.mesh.triangles)
    plain = replace(
        surface,
        normals=np.tile(np.array([0.0, 0.0, 1.0]), (count, 3, 1)),
        frames=surface.frames._replace(tangents=np.tile(np.array([1.0, 0.0, 0.0]), (count, 1)), sides=np.ones(count))
        if surface.frames is not None
        else None,
    )
    return plain.shaded_normals(faces, weights)


def corner_tangents(mesh: Mesh, normals: FloatArray, T: FloatArray) -> FloatArray:
    """(m, 3, 3) tangents at corners: means over the triangles with the same point, normal and coordinates, weighted by
    angles, each made perpendicular to the normal first. Source: Mikkelsen 2008, "Simulation of wrinkled surfaces
    revisited", section 2.5.
    """
    keys = np.concatenate([mesh.points[mesh.triangles], np.round(normals, 4), mesh.uvs[0]], axis=2).reshape(-1, 8)
    _, group = np.unique(np.round(keys, 9), axis=0, return_inverse=True)
    corners = mesh.points[mesh.triangles]
    ahead, back = (unit(np.asarray(np.roll(corners, s, axis=1) - corners, dtype=np.float64)) for s in (-1, 1))
    angles = np.arccos(np.clip(np.einsum("mci,mci->mc", ahead, back), -1.0, 1.0)).reshape(-1)
    N = normals.reshape(-1, 3)
    each = np.repeat(T, 3, axis=0)
    level = unit(each - np.einsum("ki,ki->k", each, N)[:, None] * N) * angles[:, None]
    sums = np.stack([np.bincount(group.reshape(-1), weights=level[:, k]) for k in range(3)], axis=1)
    return unit(sums.astype(np.float64))[group.reshape(-1)].reshape(-1, 3, 3)


def _print_simplifiers(label: str, scan: Model, faces: int) -> None:
    """Mean distances in shares of the largest edge, silhouettes, seconds of each way; of the heaviest mesh alone."""
    mesh = max(_upright(scan).meshes, key=lambda m: len(m.triangles))
    frame = annotation_frame(mesh.points.min(axis=0), mesh.points.max(axis=0))
    surface = weld_points(frame.from_asset(mesh.points), mesh.triangles)
    for name, reduce in SIMPLIFIERS.items():
        started = time.process_time()
        light = reduce(surface, faces)
        seconds = time.process_time() - started
        away = two_way_distance(*surface, *light)
        pairs = [
            [silhouette(Rays(*each), view, frame.extent, 512) for view in STANDARD_VIEWS] for each in (surface, light)
        ]
        iou = min(float((a & b).sum() / (a | b).sum()) for a, b in zip(*pairs, strict=True))
        mean = 1e4 * max(away.a_to_b_mean, away.b_to_a_mean)
        print(f"| {label} | {name} | {len(light[1])} | {mean:.1f} | {iou:.4f} | {seconds:.1f} |", flush=True)


def _fast(surface: Surfaces, faces: int) -> Surfaces:
    points, triangles = fast_simplification.simplify(
        surface[0].astype(np.float32), surface[1].astype(np.int32), target_count=faces
    )
    return np.asarray(points, dtype=np.float64), triangles


def _meshlab(surface: Surfaces, faces: int) -> Surfaces:
    meshes = MeshSet()
    meshes.add_mesh(LabMesh(*surface))
    meshes.meshing_decimation_quadric_edge_collapse(  # stated in full, since values of the last call are defaults
        targetfacenum=faces,
        qualitythr=0.3,
        preserveboundary=True,
        boundaryweight=1.0,
        preservenormal=True,
        preservetopology=False,
        optimalplacement=True,
        planarquadric=False,
        planarweight=0.001,
    )
    return np.asarray(meshes.current_mesh().vertex_matrix()), np.asarray(meshes.current_mesh().face_matrix())


def _both(surface: Surfaces, faces: int) -> Surfaces:
    return remesh_worker.simplified(*surface, faces)


SIMPLIFIERS: dict[str, Callable[[Surfaces, int], Surfaces]] = {
    "fast-simplification": _fast,
    "MeshLab": _meshlab,
    "both in a row": _both,
}


if __name__ == "__main__":
    main()
