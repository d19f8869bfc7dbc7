"""Voxel hull: a closed proxy for a surface with gaps, bounding what a flood fill from outside does not reach."""

from __future__ import annotations

from typing import Any, cast

import manifold3d
import numpy as np
from scipy import ndimage

from schemas.arrays import BoolArray, FloatArray, IntArray

VOXEL_CELLS = 56
LEAST_PIECE_SHARE = 0.01
# The flood keeps this many cells away from the surface, so that gaps of twice the width let nothing through ...
BERTH_CELLS = 0.75
# ... and then comes nearer in this many steps, as far as the surface lets it.
APPROACH_STEPS = 2
# A node on a face is on neither side: the flood could cross the face there.
ON_SURFACE = 0.05


def voxel_hull(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray, float] | None:
    """Points, triangles of a closed outward surface and the cell size used; None when nothing lies inside.

    The longest side has 56 cells. Outside is what a flood through the grid reaches from a corner, first at a distance
    from the surface, then up to it along links that no face cuts; sheets and walls inside do not matter. The surface
    is the zero level of the distance signed with that (manifold3d level set, marching tetrahedra), accurate to about
    half a cell at sharp edges. Idea: Nooruddin and Turk 2003, "Simplification and repair of polygonal models using
    volumetric techniques".
    """
    import open3d as o3d  # Costs a second and 200 MB: loaded only when needed.

    low, high = points[triangles].reshape(-1, 3).min(axis=0), points[triangles].reshape(-1, 3).max(axis=0)
    cell = float((high - low).max()) / VOXEL_CELLS
    shape = np.ceil((high - low) / cell).astype(int) + 5
    start = 0.5 * (low + high) - 0.5 * (shape - 1) * cell
    centre, scale = 0.5 * (low + high), float((high - low).max())
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(((points - centre) / scale).astype(np.float32)),
        o3d.core.Tensor.from_numpy(triangles.astype(np.uint32)),
    )
    grid = np.stack(np.meshgrid(*(np.arange(int(n)) for n in shape), indexing="ij"), axis=-1).reshape(-1, 3)
    nodes = ((start + grid * cell - centre) / scale).astype(np.float32)
    distance = scene.compute_distance(o3d.core.Tensor.from_numpy(nodes)).numpy().astype(np.float64).reshape(shape)
    cells_away = distance * scale / cell
    outside = _flooded(cells_away > BERTH_CELLS, cells_away > ON_SURFACE, _links(scene, nodes, shape, cell / scale))
    inside = _without_specks(~outside)
    if not inside.any():
        return None
    field = scale * cast(FloatArray, np.where(inside, distance, -distance))
    body = manifold3d.Manifold.level_set(
        _Trilinear(field, start - centre, cell), [*(low - centre - 1.5 * cell), *(high - centre + 1.5 * cell)], cell
    )
    if body.status() != manifold3d.Error.NoError or body.is_empty():
        return None
    pieces = body.decompose()  # Cavities have negative volume; the flood fill did not reach them.
    largest = max(piece.volume() for piece in pieces)
    large_pieces = [piece for piece in pieces if piece.volume() >= LEAST_PIECE_SHARE * largest]
    mesh = manifold3d.Manifold.batch_boolean(large_pieces, manifold3d.OpType.Add).to_mesh64()
    return np.array(mesh.vert_properties)[:, :3] + centre, np.array(mesh.tri_verts).astype(np.int32), cell


def _links(scene: Any, nodes: FloatArray, shape: IntArray, cell: float) -> list[BoolArray]:
    """Per axis: True where no face lies between a node and the next one along the axis."""
    import open3d as o3d

    free: list[BoolArray] = []
    for axis in range(3):
        rays = np.concatenate([nodes, np.broadcast_to(np.eye(3, dtype=np.float32)[axis], nodes.shape)], axis=1)
        hit = scene.cast_rays(o3d.core.Tensor.from_numpy(rays))["t_hit"].numpy().reshape(shape)
        free.append(hit > cell)
    return free


def _flooded(clear: BoolArray, off: BoolArray, free: list[BoolArray]) -> BoolArray:
    """The nodes reached from a corner of the grid through `clear` nodes, then by `free` links between those `off`."""
    label = np.empty(clear.shape, dtype=np.int32)
    ndimage.label(clear, output=label)
    outside, near = label == label[0, 0, 0], off & ~clear
    for _ in range(APPROACH_STEPS):
        grown = outside.copy()
        for axis, open_ in enumerate(free):
            here, there = [slice(None)] * 3, [slice(None)] * 3
            here[axis], there[axis] = slice(None, -1), slice(1, None)
            a, b, way = tuple(here), tuple(there), open_[tuple(here)]
            grown[b] |= outside[a] & way & near[b]
            grown[a] |= outside[b] & way & near[a]
        outside = grown
    return outside


def _without_specks(inside: BoolArray) -> BoolArray:
    """The occupied cells without sheets and specks one cell thick, and with enclosed gaps closed."""
    return np.asarray(ndimage.binary_fill_holes(ndimage.binary_opening(inside)))


class _Trilinear:
    """Trilinear interpolation of a grid, as the scalar function of the level set."""

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
