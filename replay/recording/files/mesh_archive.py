"""Archives `meshes_body_frame.npz`: `<body>|<geom>|v` vertices (n, 3) in the frame of the body, in metres."""

from __future__ import annotations

from pathlib import Path

from replay.recording.files.archives import read_arrays
from replay.recording.recorded_numbers import checked_numbers, invalid_recording
from schemas.arrays import FloatArray
from schemas.robot_description import DescribedLink, DescribedShape

MESHES = "meshes_body_frame.npz"


class MeshArchive:
    """Vertices by body and geom; a geom without a name is called `geom<number>`."""

    def __init__(self, path: Path) -> None:
        try:
            found = read_arrays(path, lambda key: key.endswith("|v"))
        except FileNotFoundError:
            found = {}
        self.by_key = {key[:-2]: points for key, points in found.items()}

    @classmethod
    def beside(cls, file: Path) -> MeshArchive | None:
        """The archive in the folder of a file or one folder up; None where there is none."""
        archives = [folder / MESHES for folder in (file.parent, file.parent.parent) if (folder / MESHES).is_file()]
        return cls(archives[0]) if archives else None

    def points(self, body: DescribedLink, geom: DescribedShape, number: int) -> FloatArray:
        """Vertices (n, 3) in the frame of the body. Raises InvalidInput where there are none."""
        name = geom.name or f"geom{number}"
        corners = self.by_key.get(f"{body.name}|{name}")
        if corners is None:
            raise invalid_recording("replay/missing-mesh", f"no mesh of geom '{name}' of body '{body.name}'", MESHES)
        return checked_numbers(corners, f"{body.name}|{name}", MESHES)
