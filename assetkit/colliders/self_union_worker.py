"""Entry of the self-union cell: `python -m assetkit.colliders.self_union_worker IN.npz OUT.npz CPU_SECONDS`.

MeshLab's boolean is exact (Zhou, Grinspun, Zorin and Jacobson 2016, "Mesh arrangements for solid geometry", by libigl
and CGAL) but throws or aborts on some inputs. IN holds `points` (n, 3) and `triangles` (m, 3) of a closed surface
within the unit cube; OUT holds those of the surface around everything it winds about at least once, and
`intersecting_faces` (2,) before and after.
"""

from __future__ import annotations

import resource
import sys

import numpy as np
from pymeshlab.pmeshlab import Mesh, MeshSet

# The union needs a second operand; this one is far away, and is dropped from the result by its place.
_FAR = 10.0
_FAR_POINTS = _FAR + 0.1 * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_FAR_TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def main(source: str, target: str, cpu_seconds: int) -> None:
    """Read, unite, write; the system ends the process (SIGXCPU) when it has used `cpu_seconds`."""
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds + 1))
    with np.load(source) as job:
        points, triangles = job["points"], job["triangles"]
    meshes = MeshSet()
    meshes.add_mesh(Mesh(_FAR_POINTS, _FAR_TRIANGLES))
    meshes.add_mesh(Mesh(points, triangles))
    before = _intersecting(meshes)
    meshes.generate_boolean_union(first_mesh=1, second_mesh=0)
    after = _intersecting(meshes)
    points, triangles = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    near = (points[triangles] < 0.5 * _FAR).all(axis=(1, 2))
    np.savez(target, points=points, triangles=triangles[near], intersecting_faces=np.array([before, after]))


def _intersecting(meshes: MeshSet) -> int:
    meshes.compute_selection_by_self_intersections_per_face()
    return int(meshes.current_mesh().selected_face_number())


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
