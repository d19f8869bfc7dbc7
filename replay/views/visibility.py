"""Share of the task objects' pixels that inserted bodies newly hide from the recorded cameras, by ray casting.

Exact for the planes of hulls and boxes; round shapes are polyhedra inscribed in them. Pixels that recorded bodies hide
anyway do not count: only pixels that show a task object without the inserted bodies are tested.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from geom.convex.support_function import surface
from geom.pose import apply
from replay.recording.episode import Camera, Episode
from replay.recording.kinematics import link_poses
from replay.views.visible_area import ROWS
from schemas.arrays import FloatArray, IntArray
from schemas.physics import CollisionShape

LONGEST_PX = 128  # larger pictures are tested at this size


@dataclass(frozen=True)
class ConvexPolyhedron:
    """A convex polyhedron in W: inside where normals (f, 3) @ p <= offsets (f,); its corners (n, 3)."""

    normals: FloatArray
    offsets: FloatArray
    corners: FloatArray


@dataclass(frozen=True)
class TaskPixels:
    """Pixels of one camera at one row that show a task object: rays eye + depth * directions (r, 3), depths (r,) m."""

    camera: str
    eye: FloatArray
    directions: FloatArray
    depths: FloatArray


def task_pixels(
    episode: Episode, cameras: Sequence[Camera] | None = None, rows: Sequence[int] | None = None
) -> tuple[TaskPixels, ...]:
    """Pixels of the recorded objects in cameras (by default all) at rows (by default `ROWS` of them)."""
    chosen = np.unique(np.linspace(0, len(episode.t_s) - 1, ROWS).astype(int)) if rows is None else np.asarray(rows)
    objects = [convex_polyhedra(body.shapes) for body in episode.objects]
    standing = [
        in_world(convex, fixture.X_WB) for fixture in episode.fixtures for convex in convex_polyhedra(fixture.shapes)
    ]
    links = [(robot, [convex_polyhedra(link.shapes) for link in robot.links]) for robot in episode.robots]
    pixels = []
    for row in chosen.tolist():
        others = list(standing)
        for robot, shapes in links:
            X_WL = link_poses(robot, robot.q[row : row + 1], robot.X_WR[row : row + 1])[0]
            others += [in_world(convex, X) for X, some in zip(X_WL, shapes, strict=True) for convex in some]
        bodies = [
            [in_world(convex, body.X_WB[row]) for convex in some]
            for body, some in zip(episode.objects, objects, strict=True)
        ]
        for camera in episode.cameras if cameras is None else cameras:
            pixels += _seen(camera, camera.X_WC[row], bodies, others)
    return tuple(pixels)


def newly_hidden(seen: Iterable[TaskPixels], inserted: Sequence[ConvexPolyhedron]) -> dict[str, float]:
    """Share of the pixels of task objects, over all rows, that the inserted bodies hide; 0 where there are none."""
    before: dict[str, int] = {}
    hidden: dict[str, int] = {}
    for one in seen:
        gone = _depths(inserted, one.eye, one.directions) < one.depths
        before[one.camera] = before.get(one.camera, 0) + len(gone)
        hidden[one.camera] = hidden.get(one.camera, 0) + int(gone.sum())
    return {name: hidden[name] / before[name] for name in before}


def convex_polyhedra(shapes: Iterable[CollisionShape]) -> list[ConvexPolyhedron]:
    """Shapes as polyhedra in the frame of their body."""
    return [_convex(shape) for shape in shapes]


def in_world(convex: ConvexPolyhedron, X_WB: FloatArray) -> ConvexPolyhedron:
    """The polyhedron at pose X_WB, in W."""
    normals = convex.normals @ X_WB[:3, :3].T
    return ConvexPolyhedron(normals, convex.offsets + normals @ X_WB[:3, 3], apply(X_WB, convex.corners))


def _convex(shape: CollisionShape) -> ConvexPolyhedron:
    corners, triangles = surface(shape)
    first, second, third = (corners[triangles[:, k]] for k in range(3))
    normals = np.cross(second - first, third - first)
    length = np.linalg.norm(normals, axis=1)
    normals = normals[length > 0.0] / length[length > 0.0, None]
    offsets = np.einsum("ij,ij->i", normals, first[length > 0.0])
    rounded = np.round(np.column_stack([normals, offsets]), 9)
    planes = np.asarray(np.unique(rounded, axis=0), dtype=np.float64)  # One for the triangles of a face.
    return ConvexPolyhedron(planes[:, :3], planes[:, 3], corners)


def _seen(
    camera: Camera, X_WC: FloatArray, bodies: Sequence[Sequence[ConvexPolyhedron]], others: Sequence[ConvexPolyhedron]
) -> Iterator[TaskPixels]:
    """One `TaskPixels` with the pixels of all objects, if there are any."""
    shrink = min(1.0, LONGEST_PX / max(camera.width_px, camera.height_px))
    width, height = (max(1, round(size * shrink)) for size in (camera.width_px, camera.height_px))
    slope = np.tan(camera.fovy_rad / 2.0) * 2.0 / height  # metres at 1 m for each pixel
    pixels: dict[tuple[int, int], float] = {}
    eye = X_WC[:3, 3]
    picture = partial(_box, X_WC=X_WC, slope=slope, width=width, height=height)
    for body in bodies:
        box = picture(np.concatenate([c.corners for c in body]))
        if box is None:
            continue
        x, y = np.meshgrid(np.arange(box[0], box[2]), np.arange(box[1], box[3]))
        directions = _directions(X_WC, x.ravel(), y.ravel(), slope, width, height)
        depths = _depths(body, eye, directions)
        shown = np.flatnonzero(np.isfinite(depths))
        for other in others:
            if len(shown) and _before(other, X_WC, depths[shown].max()) and _overlap(picture(other.corners), box):
                shown = shown[_depths([other], eye, directions[shown]) >= depths[shown]]
        for k in shown.tolist():
            pixel = int(x.flat[k]), int(y.flat[k])
            pixels[pixel] = min(float(depths[k]), pixels.get(pixel, np.inf))
    if pixels:
        columns, rows = np.array(list(pixels)).T
        yield TaskPixels(
            camera.name, eye, _directions(X_WC, columns, rows, slope, width, height), np.array(list(pixels.values()))
        )


def _directions(X_WC: FloatArray, x: IntArray, y: IntArray, slope: float, width: int, height: int) -> FloatArray:
    """(r, 3) rays in W through the middles of pixels, of length 1 along the optical axis; y counts down."""
    right, up = (x + 0.5 - width / 2.0) * slope, (height / 2.0 - y - 0.5) * slope
    return np.column_stack([right, up, np.full(len(x), -1.0)]) @ X_WC[:3, :3].T


def _box(
    corners: FloatArray, X_WC: FloatArray, slope: float, width: int, height: int
) -> tuple[int, int, int, int] | None:
    """Columns and rows (x0, y0, x1, y1) that may show the points; None where these are behind or beside the picture."""
    points_C = (corners - X_WC[:3, 3]) @ X_WC[:3, :3]
    depth = -points_C[:, 2]
    if depth.max() <= 0.0:
        return None
    if depth.min() <= 1e-6:
        return 0, 0, width, height
    x, y = points_C[:, 0] / depth / slope + width / 2.0, height / 2.0 - points_C[:, 1] / depth / slope
    x0, y0 = max(0, int(np.floor(x.min()))), max(0, int(np.floor(y.min())))
    x1, y1 = min(width, int(np.ceil(x.max()))), min(height, int(np.ceil(y.max())))
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def _before(body: ConvexPolyhedron, X_WC: FloatArray, depth_m: float) -> bool:
    """Whether some of it is nearer along the optical axis."""
    return bool(((X_WC[:3, 3] - body.corners) @ X_WC[:3, 2]).min() < depth_m)


def _overlap(one: tuple[int, int, int, int] | None, other: tuple[int, int, int, int]) -> bool:
    return one is not None and one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _depths(bodies: Sequence[ConvexPolyhedron], eye: FloatArray, directions: FloatArray) -> FloatArray:
    """(r,) depth along the optical axis at which each ray enters the first of the bodies, infinite where it misses."""
    nearest = np.full(len(directions), np.inf)
    lengths = np.linalg.norm(directions, axis=1)
    for body in bodies:
        some = _towards(body, eye, directions, lengths)
        if not len(some):
            continue
        room = body.offsets - body.normals @ eye
        speed = directions[some] @ body.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = room / speed
        enters = np.max(crossing, axis=1, where=speed < 0.0, initial=0.0)
        leaves = np.min(crossing, axis=1, where=speed > 0.0, initial=np.inf)
        beside = ((speed == 0.0) & (room < 0.0)).any(axis=1)
        meets = (enters <= leaves) & ~beside
        nearest[some[meets]] = np.minimum(nearest[some[meets]], enters[meets])
    return nearest


def _towards(body: ConvexPolyhedron, eye: FloatArray, directions: FloatArray, lengths: FloatArray) -> IntArray:
    """Numbers of the rays that meet the ball around a body's corners."""
    middle = body.corners.mean(axis=0)
    radius = np.linalg.norm(body.corners - middle, axis=1).max()
    along = directions @ (middle - eye) / lengths
    apart = float((middle - eye) @ (middle - eye)) - along**2
    return np.flatnonzero(apart <= (radius * (1.0 + 1e-9)) ** 2)
