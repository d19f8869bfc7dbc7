"""Geometry processing on plain arrays: points (n, 3), triangles (m, 3), poses (4, 4); no files and no simulator.

Folders from the ground up: `mesh` (triangle surfaces), `mass`, `convex` and `repair`, then `solid` (closed bodies from
visual meshes), `features` (cavities, supports, holes), `decomposition` (convex parts) and `grasp`. First read `pose`.
"""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from geom.convex.hull import convex_hull
    from geom.decomposition.decompose import convex_parts
    from geom.mass.inertia import enclosed_volume
    from geom.mesh.topology import observe
    from geom.mesh.weld import weld_points
    from geom.pose import pose_from_quat
    from geom.repair.holes import fill_openings

__all__ = [
    "convex_hull",
    "convex_parts",
    "enclosed_volume",
    "fill_openings",
    "observe",
    "pose_from_quat",
    "weld_points",
]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "convex_hull": "geom.convex.hull",
        "convex_parts": "geom.decomposition.decompose",
        "enclosed_volume": "geom.mass.inertia",
        "fill_openings": "geom.repair.holes",
        "observe": "geom.mesh.topology",
        "pose_from_quat": "geom.pose",
        "weld_points": "geom.mesh.weld",
    },
)
