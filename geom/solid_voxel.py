"""A closed stand-in for a surface that encloses volume but has gaps: parity of rays on a grid, contoured."""

from __future__ import annotations

import manifold3d
import numpy as np
from scipy import ndimage

from schemas.model import FloatArray, IntArray

CELLS = 40
LEAST_PIECE_SHARE = 0.01
# Seven fixed directions in general position; a point is inside when most rays cross the surface an odd number of times.
_DIRECTIONS = np.array(
    [
        [0.913, 0.287, 0.291],
        [-0.871, 0.412, -0.268],
        [0.213, 0.951, -0.224],
        [-0.331, -0.902, 0.277],
        [0.187, -0.243, 0.952],
        [0.274, 0.329, -0.904],
        [-0.548, 0.611, 0.571],
    ],
    dtype=np.float32,
)


def voxel_hull(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray, float] | None:
    """Points, triangles of a closed outward surface and the cell size used; None when nothing lies inside.

    The longest side has 40 cells. Inside is decided by ray parity (Nooruddin and Turk 2003, "Simplification and
    repair of polygonal models using volumetric techniques", section 3), the surface is the zero level of the signed
    distance (manifold3d level set, marching tetrahedra), accurate to about one cell.
    """
    import open3d as o3d  # Costs a second and 200 MB: loaded only when needed.

    low, high = points[triangles].reshape(-1, 3).min(axis=0), points[triangles].reshape(-1, 3).max(axis=0)
    cell = float((high - low).max()) / CELLS
    shape = np.ceil((high - low) / cell).astype(int) + 5
    start = 0.5 * (low + high) - 0.5 * (shape - 1) * cell
    centre, scale = 0.5 * (low + high), float((high - low).max())
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(((points - centre) / scale).astype(np.float32)),
        o3d.core.Tensor.from_numpy(triangles.astype(np.uint32)),
    )
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1).reshape(-1, 3)
    queries = ((start + grid * cell - centre) / scale).astype(np.float32)
    votes = np.zeros(len(queries), dtype=np.int64)
    for direction in _DIRECTIONS:
        rays = np.concatenate([queries, np.broadcast_to(direction, queries.shape)], axis=1)
        votes += scene.count_intersections(o3d.core.Tensor.from_numpy(rays)).numpy() % 2
    inside = _without_specks((votes > len(_DIRECTIONS) // 2).reshape(shape))
    if not inside.any():
        return None
    distance = scene.compute_distance(o3d.core.Tensor.from_numpy(queries)).numpy().astype(np.float64) * scale
    field = np.where(inside, distance.reshape(shape), -distance.reshape(shape))
    body = manifold3d.Manifold.level_set(
        _Trilinear(field, start - centre, cell), [*(low - centre - 1.5 * cell), *(high - centre + 1.5 * cell)], cell
    )
    if body.status() != manifold3d.Error.NoError or body.is_empty():
        return None
    pieces = body.decompose()  # Cavities come out with negative volume; they are gaps in the votes, not design.
    largest = max(piece.volume() for piece in pieces)
    kept = [piece for piece in pieces if piece.volume() >= LEAST_PIECE_SHARE * largest]
    mesh = manifold3d.Manifold.batch_boolean(kept, manifold3d.OpType.Add).to_mesh64()
    return np.array(mesh.vert_properties)[:, :3] + centre, np.array(mesh.tri_verts).astype(np.int32), cell


def _without_specks(inside: FloatArray) -> FloatArray:
    """The occupied cells without sheets and specks one cell thick, and with enclosed gaps closed."""
    return np.asarray(ndimage.binary_fill_holes(ndimage.binary_opening(inside)))


class _Trilinear:
    """Trilinear interpolation of a grid, as the scalar function that the level set asks for."""

    def __init__(self, field: FloatArray, start: FloatArray, cell: float) -> None:
        self.values = field.tolist()
        self.start = start.tolist()
        self.cell = cell
        self.last = [n - 2 for n in field.shape]

    def __call__(self, x: float, y: float, z: float) -> float:
        position = [(p - s) / self.cell for p, s in zip((x, y, z), self.start, strict=True)]
        i, j, k = (min(max(int(p), 0), n) for p, n in zip(position, self.last, strict=True))
        u, v, w = position[0] - i, position[1] - j, position[2] - k
        near, far = self.values[i], self.values[i + 1]

        def along_z(plane: list[list[float]], row: int) -> float:
            return plane[row][k] * (1.0 - w) + plane[row][k + 1] * w

        front = along_z(near, j) * (1.0 - v) + along_z(near, j + 1) * v
        back = along_z(far, j) * (1.0 - v) + along_z(far, j + 1) * v
        return front * (1.0 - u) + back * u
