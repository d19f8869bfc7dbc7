"""Writes small USD files for tests, and reads them with `assetkit.readers.usd`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assetkit.readers.usd import read_usd
from assetkit.sources.source_file import SourceFile
from schemas.appearance.material import Material
from schemas.diagnostics import Diagnostic, InvalidInput
from schemas.model import Mesh, Model
from schemas.outcome import Outcome

HEADER = 'defaultPrim = "Root"\n metersPerUnit = 1\n upAxis = "Z"'
QUAD = """int[] faceVertexCounts = [4]
 int[] faceVertexIndices = [0, 1, 2, 3]
 point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
 uniform token subdivisionScheme = "none"
"""


def write(folder: Path, body: str, header: str = HEADER, root: str = 'def Xform "Root"') -> Path:
    """A layer with one root prim; closing braces get the line breaks that the grammar requires."""
    path = folder / "part.usda"
    body = body.replace("}", "\n}\n")
    path.write_text(f"#usda 1.0\n(\n {header}\n)\n{root} {{\n {body}\n}}\n")
    return path


def read(path: Path) -> Outcome[Model]:
    return read_usd(SourceFile(path, path.parent))


def model_of(path: Path) -> Model:
    model = read(path).value
    assert model is not None
    return model


def only_mesh(path: Path) -> Mesh:
    (mesh,) = model_of(path).meshes
    return mesh


def rejection(path: Path) -> Diagnostic:
    with pytest.raises(InvalidInput) as caught:
        read(path)
    return caught.value.diagnostic


def corners(mesh: Mesh) -> np.ndarray:
    """(m, 3, 3) points of the triangles."""
    return mesh.points[mesh.triangles]


def area_vector(mesh: Mesh) -> np.ndarray:
    a, b, c = np.moveaxis(corners(mesh), 1, 0)
    return np.cross(b - a, c - a).sum(axis=0) / 2


def volume(mesh: Mesh) -> float:
    return float(np.linalg.det(corners(mesh)).sum() / 6)


def material_of(path: Path) -> Material:
    (material,) = model_of(path).materials
    return material


def preview(name: str, inputs: str, nodes: str = "") -> str:
    return f"""def Material "{name}" {{
      token outputs:surface.connect = </Root/{name}/s.outputs:surface>
      def Shader "s" {{ uniform token info:id = "UsdPreviewSurface"
        {inputs}
        token outputs:surface
      }}
      {nodes}
    }}"""
