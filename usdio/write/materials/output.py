"""One shader that is written for a material: its name, its render context, what it cannot show, how it is authored."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from schemas.appearance.material import Texture
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.network import Network

VERTEX_COLORS = "vertex colours"


@dataclass(frozen=True)
class ShaderOutput:
    """A row of `outputs.OUTPUTS`.

    name     of the shader, as in the record.
    context  render context of the surface output; "" is the universal one, which every renderer reads.
    lost     (mesh material, textures by name) -> fields of the material, of layers as "sheen.color", or VERTEX_COLORS,
             that the shader does not show; the material is an `effective` one.
    author   writes the network and connects the surface of the material.
    """

    name: str
    context: str
    lost: Callable[[MeshMaterial, Mapping[str, Texture]], frozenset[str]]
    author: Callable[[Network, MeshMaterial], None]
