"""Entry of the remeshing cell: `python -m assetkit.retopo.remesh_worker IN.npz OUT.npz CPU_SECONDS`.

MeshLab, fast-simplification and xatlas abort or hang on some inputs; this process has limits. IN holds `size_px`,
`padding_px`, and per mesh k `points_k` (n, 3), `triangles_k` (m, 3) and `faces_k`, the wanted number of faces. OUT
holds per mesh `points_k`, `triangles_k` and `uvs_k` (m, 3, 2), coordinates in one square picture for all meshes.

Simplification is quadric edge collapse (Garland and Heckbert 1997), see `simplified`; the atlas is made by xatlas
(Young 2018, after thekla_atlas).
"""

from __future__ import annotations

import resource
import sys

import fast_simplification
import numpy as np
import xatlas
from pymeshlab.pmeshlab import Mesh, MeshSet

from geom.mesh.surface_distance import two_way_distance

# Chosen by mean distance and silhouettes on dev assets of 190,000 to 750,000 triangles, with and without ripples;
# `python -m benchmarks.assets.retopo ASSETS --simplifiers` compares the result with either library alone.
_COARSE_FACTOR, _AGGRESSION = 4, 3
# Half of what 5,000 triangles cost; the first step has lost a part where it departs by more.
_COARSE_DISTANCE_SHARE = 5e-5
_LEAST_QUALITY, _PLANAR_WEIGHT = 0.1, 1e-4
_LEAST_AREA_SHARE = 1e-14  # of the area of the square of the extent: smaller triangles have no direction in float32


def main(source: str, target: str, cpu_seconds: int) -> None:
    """Read, simplify, unwrap, write; the system ends the process (SIGXCPU) when it has used `cpu_seconds`."""
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds + 1))
    with np.load(source) as job:
        given = {key: job[key] for key in job.files}
    count = sum(key.startswith("points_") for key in given)
    surfaces = [
        simplified(given[f"points_{k}"], given[f"triangles_{k}"], int(given[f"faces_{k}"])) for k in range(count)
    ]
    uvs = _unwrapped(surfaces, int(given["size_px"]), int(given["padding_px"]))
    results: dict[str, np.ndarray] = {}
    for k, (points, triangles) in enumerate(surfaces):
        results |= {f"points_{k}": points, f"triangles_{k}": triangles, f"uvs_{k}": uvs[k]}
    np.savez(target, allow_pickle=False, **results)


def simplified(points: np.ndarray, triangles: np.ndarray, faces: int) -> tuple[np.ndarray, np.ndarray]:
    """About `faces` triangles: first to four times as many by fast-simplification, the rest by MeshLab.

    Where the first step already departs from the surface, MeshLab also goes the whole way, and the nearer result is
    taken.
    """
    if len(triangles) <= _COARSE_FACTOR * faces:
        return _reduced(points, triangles, faces)
    coarse = _coarse(points, triangles, _COARSE_FACTOR * faces)
    result = _reduced(*coarse, faces)
    extent = float(np.ptp(points, axis=0).max())
    if _distance((points, triangles), coarse) <= _COARSE_DISTANCE_SHARE * extent:
        return result
    other = _reduced(points, triangles, faces)
    return min((result, other), key=lambda light: _distance((points, triangles), light))


def _distance(first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]) -> float:
    """The larger of both mean distances between two surfaces."""
    away = two_way_distance(*first, *second)
    return max(away.a_to_b_mean, away.b_to_a_mean)


def _reduced(points: np.ndarray, triangles: np.ndarray, faces: int) -> tuple[np.ndarray, np.ndarray]:
    """About `faces` triangles by MeshLab; boundaries weigh as much as the surface, so that rims of open scans stay."""
    meshes = MeshSet()
    meshes.add_mesh(Mesh(points, triangles))
    if len(triangles) > faces:
        # MeshLab keeps the values of the last call as defaults of the next one: all that matter are stated.
        meshes.meshing_decimation_quadric_edge_collapse(
            targetfacenum=faces,
            targetperc=0.0,
            qualitythr=_LEAST_QUALITY,
            preserveboundary=True,
            boundaryweight=1.0,
            preservenormal=True,
            preservetopology=False,
            optimalplacement=True,
            planarquadric=True,
            planarweight=_PLANAR_WEIGHT,
            qualityweight=False,
        )
    meshes.meshing_remove_null_faces()
    meshes.meshing_remove_unreferenced_vertices()
    light = meshes.current_mesh()
    return _with_area(np.asarray(light.vertex_matrix()), np.asarray(light.face_matrix(), dtype=np.int32))


def _coarse(points: np.ndarray, triangles: np.ndarray, faces: int) -> tuple[np.ndarray, np.ndarray]:
    single = points.astype(np.float32)
    results = fast_simplification.simplify(single, triangles.astype(np.int32), target_count=faces, agg=_AGGRESSION)
    return np.asarray(results[0], dtype=np.float64), np.asarray(results[1], dtype=np.int32)


def _with_area(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The surface without triangles that have no area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    doubled = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return points, triangles[doubled > _LEAST_AREA_SHARE * np.ptp(points, axis=0).max() ** 2]


def _unwrapped(surfaces: list[tuple[np.ndarray, np.ndarray]], size_px: int, padding_px: int) -> list[np.ndarray]:
    """Per surface the texture coordinates (m, 3, 2) of its triangle corners in the unit square, without overlap."""
    atlas = xatlas.Atlas()
    for points, triangles in surfaces:
        atlas.add_mesh(points.astype(np.float32), triangles.astype(np.uint32))
    packing = xatlas.PackOptions()
    packing.resolution, packing.padding, packing.bilinear = size_px, padding_px, True
    atlas.generate(xatlas.ChartOptions(), packing, False)
    if atlas.atlas_count != 1:
        raise RuntimeError(f"{atlas.atlas_count} pictures instead of one")
    square = np.array([atlas.width, atlas.height]) / max(atlas.width, atlas.height)
    return [_corner_uvs(atlas, k, len(triangles)) * square for k, (_, triangles) in enumerate(surfaces)]


def _corner_uvs(atlas: xatlas.Atlas, index: int, count: int) -> np.ndarray:
    """(m, 3, 2) coordinates of one mesh, in the order of its triangles, v pointing up."""
    _, corners, uvs = atlas[index]
    if len(corners) != count:
        raise RuntimeError(f"{len(corners)} of {count} triangles have texture coordinates")
    return np.asarray(uvs, dtype=np.float64)[np.asarray(corners, dtype=np.int64)]


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
