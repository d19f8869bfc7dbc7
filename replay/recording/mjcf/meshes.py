"""Vertices (m, body frame) of the meshes that a MuJoCo model names or holds."""

from __future__ import annotations

from pathlib import Path

from geom.pose import apply
from replay.recording.mjcf.bodies import RecordedBodies
from replay.recording.shapes import described_mesh
from schemas.arrays import FloatArray
from schemas.robot_description import DescribedLink, DescribedShape


class MeshFiles:
    """Vertices from files below `root`, else from the folder `meshes` that the user names; each file is read once."""

    def __init__(self, model: RecordedBodies, root: Path, meshes: Path | None) -> None:
        self.file, self.root, self.meshes = model.file, root, meshes
        self.read: dict[str, FloatArray] = {}

    def points(self, body: DescribedLink, geom: DescribedShape, number: int) -> FloatArray:
        """Vertices (n, 3) in the frame of the body. Raises InvalidInput."""
        mesh = geom.mesh
        if mesh is None:
            raise ValueError(f"geom {number} of body '{body.name}' is no mesh")
        if mesh.name not in self.read:
            self.read[mesh.name] = described_mesh(mesh, self.root, self.meshes, self.file)
        return apply(geom.X_LS, self.read[mesh.name])
