"""The formats URDF and MJCF as rows of `assetkit.readers.by_format`; the reader is loaded with the first file."""

from __future__ import annotations

from collections.abc import Mapping

from assetkit.readers.source_format import Reader, SourceFormat
from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome


def description_formats(mesh_readers: Mapping[str, Reader]) -> tuple[SourceFormat, SourceFormat]:
    """The rows of URDF and MJCF; `mesh_readers` read the meshes that they name, by extension."""

    def read(source: SourceFile) -> Outcome[Model]:
        from assetkit.readers.robot.read import read_robot  # Loads all that discovery does not need.

        return read_robot(source, mesh_readers)

    urdf = SourceFormat("urdf", (".urdf",), read, syntax="XML", referring=(".urdf",))
    marks = ((".xml", "<mujoco"),)
    mjcf = SourceFormat("mjcf", (".xml", ".mjcf"), read, syntax="XML", referring=(".xml", ".mjcf"), marks=marks)
    return urdf, mjcf
