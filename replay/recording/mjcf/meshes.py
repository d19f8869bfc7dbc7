"""Vertices (m, body frame) of the mesh files that a MuJoCo model names."""

from __future__ import annotations

from pathlib import Path

from geom.pose import apply
from replay.recording.mjcf.read import MjBody, MjGeom, MjModel
from replay.recording.recorded_numbers import invalid_recording
from replay.recording.shapes import locate_mesh, mesh_points
from schemas.arrays import FloatArray


class MeshFiles:
    """Vertices from files below `folder`, else from the folder `meshes` that the user names; each file is read once."""

    def __init__(self, model: MjModel, folder: Path, meshes: Path | None) -> None:
        self.model, self.folder, self.meshes = model, folder, meshes
        self.read: dict[str, FloatArray] = {}

    def points(self, body: MjBody, geom: MjGeom) -> FloatArray:
        """Vertices (n, 3) in the frame of the body. Raises InvalidInput."""
        if geom.mesh not in self.read:
            if geom.mesh not in self.model.meshes:
                message = f"geom '{geom.name}' of body '{body.name}' names the unknown mesh '{geom.mesh}'"
                raise invalid_recording("replay/invalid-value", message, self.model.file)
            mesh = self.model.meshes[geom.mesh]
            absolute = mesh.file.startswith("/") or ":" in mesh.file[:2]
            name = f"{mesh.folder}/{mesh.file}" if mesh.folder and not absolute else mesh.file
            path = locate_mesh(name, self.folder, self.meshes, self.model.file)
            self.read[geom.mesh] = mesh_points(path, mesh.scale, self.model.file)
        return apply(geom.X_BG, self.read[geom.mesh])
