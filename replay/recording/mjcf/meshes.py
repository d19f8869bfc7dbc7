"""Vertices (m, body frame) of the meshes that a MuJoCo model names or holds."""

from __future__ import annotations

from pathlib import Path

from formats.mesh_points import in_shape_frame
from geom.pose import apply
from replay.recording.mjcf.bodies import RecordedBodies
from replay.recording.shapes import locate_mesh, mesh_points
from schemas.arrays import FloatArray
from schemas.robot_description import DescribedLink, DescribedShape, MeshReference

_UNSCALED = (1.0, 1.0, 1.0)


class MeshFiles:
    """Vertices from files below `folder`, else from the folder `meshes` that the user names; each file is read once."""

    def __init__(self, model: RecordedBodies, folder: Path, meshes: Path | None) -> None:
        self.file, self.folder, self.meshes = model.file, folder, meshes
        self.read: dict[str, FloatArray] = {}

    def points(self, body: DescribedLink, geom: DescribedShape, number: int) -> FloatArray:
        """Vertices (n, 3) in the frame of the body. Raises InvalidInput."""
        mesh = geom.mesh
        if mesh is None:
            raise ValueError(f"geom {number} of body '{body.name}' is no mesh")
        if mesh.name not in self.read:
            self.read[mesh.name] = in_shape_frame(mesh, self._vertices(mesh))
        return apply(geom.X_LS, self.read[mesh.name])

    def _vertices(self, mesh: MeshReference) -> FloatArray:
        """Vertices (n, 3) as the file, or the model itself, has them."""
        if mesh.vertices is not None:
            return mesh.vertices
        return mesh_points(locate_mesh(mesh.uri, self.folder, self.meshes, self.file), _UNSCALED, self.file)
