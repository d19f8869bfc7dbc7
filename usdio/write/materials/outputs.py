"""Which shaders are written for a material, and what none of them shows.

Every material has a UsdPreviewSurface, which all renderers read, an OpenPBR surface (MaterialX), and the MDL material
of NVIDIA's library for its optics. A renderer prefers the shader of its own context, so one that would show less than
UsdPreviewSurface without showing anything more is not written.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from schemas.appearance.material import Texture
from schemas.appearance.optics import effective, optics_of
from schemas.appearance.record import Optics
from usdio.write.materials.mesh_materials import MeshMaterial
from usdio.write.materials.omni_clear_coat import OMNI_CLEAR_COAT
from usdio.write.materials.omni_glass import OMNI_GLASS
from usdio.write.materials.omni_pbr import OMNI_PBR
from usdio.write.materials.open_pbr import OPEN_PBR
from usdio.write.materials.output import ShaderOutput
from usdio.write.materials.preview_surface import PREVIEW_SURFACE

# The shaders for each kind of optics, in the order of the record; the first is always written.
OUTPUTS: Final[dict[Optics, tuple[ShaderOutput, ...]]] = {
    "opaque": (PREVIEW_SURFACE, OPEN_PBR, OMNI_PBR),
    "transmissive": (PREVIEW_SURFACE, OPEN_PBR, OMNI_GLASS),
    "coated": (PREVIEW_SURFACE, OPEN_PBR, OMNI_CLEAR_COAT),
}
# Ray-traced light makes its own occlusion; a map of it only serves renderers without, which read UsdPreviewSurface.
FOR_RASTERISERS: Final = frozenset({"occlusion_texture"})


def outputs_of(mesh_material: MeshMaterial, images: Mapping[str, Texture]) -> tuple[ShaderOutput, ...]:
    """The shaders that are written for `mesh_material`; `images` are the textures by name."""
    seen = replace(mesh_material, material=effective(mesh_material.material))
    portable, *others = OUTPUTS[optics_of(mesh_material.material)]
    dropped = portable.lost(seen, images)

    def worth_it(output: ShaderOutput) -> bool:
        also_dropped = output.lost(seen, images) - FOR_RASTERISERS
        return also_dropped <= dropped or not dropped <= also_dropped

    return (portable, *(output for output in others if worth_it(output)))


def lost_by_shader(mesh_material: MeshMaterial, images: Mapping[str, Texture]) -> dict[str, frozenset[str]]:
    """The name of each shader that is written for `mesh_material` -> the fields that it does not show."""
    seen = replace(mesh_material, material=effective(mesh_material.material))
    return {output.name: output.lost(seen, images) for output in outputs_of(mesh_material, images)}
