"""The visible meshes of a package as OBJ files with MTL and PNG, and what those cannot hold of the materials.

OBJ has one set of texture coordinates and MTL a colour, an opacity and a picture of the colour. The set that the base
colour uses is written, with the transform of the texture applied to it; MuJoCo reads PNG alone, so JPEG is decoded.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path, PurePosixPath

import numpy as np
from PIL import Image

from assetkit.package.write_obj import write_obj
from assetkit.package.write_urdf import display_colour
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.arrays import Float32Array, FloatArray
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.model import Mesh, Model
from schemas.robot_description import DescribedMaterial, DescribedShape, MeshReference
from usdio.write.materials.mesh_materials import MeshMaterial, materials_per_mesh

MESHES = "meshes"  # pictures lie there too: many readers of MTL look for them beside the mesh alone
# Fields of a material that OBJ, MTL, URDF and MJCF hold, or that say nothing of its look.
_WRITTEN = frozenset(
    {"name", "base_color", "base_color_texture", "opacity", "metallic", "roughness", "origins", "unmapped"}
    | {"normal_green"}
)
_WITHOUT_EFFECT = {  # fields that count only where another one has a value other than its default
    "alpha_cutoff": "alpha_mode",
    "normal_scale": "normal_texture",
    "clearcoat_roughness": "clearcoat",
    "clearcoat_normal_scale": "clearcoat_normal_texture",
}
_PLAIN = Material(name="")


@dataclass(frozen=True)
class WrittenSurfaces:
    """The visible shapes by the link that carries them, and a finding for each material or mesh that lost something."""

    shapes: dict[str, tuple[DescribedShape, ...]]
    lost: tuple[Diagnostic, ...]


def write_surfaces(
    model: Model, link_of: Sequence[str], origins: dict[str, FloatArray], folder: Path
) -> WrittenSurfaces:
    """Write the visible meshes and their pictures to `meshes/` below `folder`.

    `link_of` names the link of each mesh, `origins` where the frame of each link lies (3,) in the frame of the model,
    metres.
    """
    (folder / MESHES).mkdir(parents=True, exist_ok=True)
    textures = {texture.name: texture for texture in model.textures}
    materials = materials_per_mesh(model)
    shapes: dict[str, list[DescribedShape]] = {}
    lost: list[Diagnostic] = []
    described: dict[str, DescribedMaterial] = {}
    for mesh, used, link in zip(model.meshes, materials, link_of, strict=True):
        if not len(mesh.triangles):
            continue
        if used.prim_name not in described:
            described[used.prim_name] = _described(used, textures, folder)
            lost += _losses(used)
        lost += _mesh_losses(mesh, used)
        shapes.setdefault(link, []).append(_shape(mesh, used, described[used.prim_name], origins[link], folder))
    return WrittenSurfaces({link: tuple(each) for link, each in shapes.items()}, tuple(lost))


def _shape(
    mesh: Mesh, used: MeshMaterial, material: DescribedMaterial, origin: FloatArray, folder: Path
) -> DescribedShape:
    """The mesh as a visible shape in the frame of its link; writes its OBJ and MTL."""
    stem = f"visual_{mesh.id}"
    colour = used.material.base_color_texture
    uvs = _placed_uvs(mesh, colour)
    (folder / MESHES / f"{stem}.mtl").write_text(_mtl(material, used.material))
    write_obj(
        folder / MESHES / f"{stem}.obj",
        mesh.points - origin,
        mesh.triangles,
        uvs,
        mesh.normals,
        (material.name, f"{stem}.mtl"),
    )
    reference = MeshReference(f"{MESHES}/{stem}.obj", name=stem)
    return DescribedShape(mesh.id, "mesh", (), np.eye(4), False, True, mesh=reference, material=material)


def _placed_uvs(mesh: Mesh, use: TextureUse | None) -> Float32Array | None:
    """The texture coordinates (m, 3, 2) with which the picture of `use` is read without a transform (UsdTransform2d:
    scale, then turn, then shift); without a picture those of the first set."""
    if use is None:
        return mesh.uvs[0] if mesh.uvs else None
    if use.uv_set >= len(mesh.uvs):
        return None
    if (use.uv_scale, use.uv_rotation_rad, use.uv_offset) == ((1.0, 1.0), 0.0, (0.0, 0.0)):
        return mesh.uvs[use.uv_set]
    cos, sin = np.cos(use.uv_rotation_rad), np.sin(use.uv_rotation_rad)
    scaled = mesh.uvs[use.uv_set].astype(np.float64) * use.uv_scale
    return (scaled @ np.array([[cos, sin], [-sin, cos]]) + use.uv_offset).astype(np.float32)


def _described(used: MeshMaterial, textures: dict[str, Texture], folder: Path) -> DescribedMaterial:
    """The material as URDF and MJCF have it; writes its picture."""
    material = used.material
    red, green, blue = display_colour(material).tolist()
    use = material.base_color_texture
    file = "" if use is None or use.texture not in textures else _write_png(textures[use.texture], folder)
    rgba = (red, green, blue, material.opacity)
    return DescribedMaterial(used.prim_name, rgba, file, metallic=material.metallic, roughness=material.roughness)


def _write_png(texture: Texture, folder: Path) -> str:
    """Write the picture as PNG, its own bytes where it is one; returns its path below `folder`."""
    name = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in texture.name) or "texture"
    taken = {path.stem: path for path in (folder / MESHES).glob("*.png")}
    data = texture.data
    if texture.extension != "png":
        buffer = io.BytesIO()
        Image.open(io.BytesIO(texture.data)).convert("RGB").save(buffer, "PNG")
        data = buffer.getvalue()
    number = 1
    stem = name
    while stem in taken and taken[stem].read_bytes() != data:
        number += 1
        stem = f"{name}_{number}"
    (folder / MESHES / f"{stem}.png").write_bytes(data)
    return f"{MESHES}/{stem}.png"


def _mtl(described: DescribedMaterial, material: Material) -> str:
    """The MTL file of one mesh: colour, opacity and picture, roughness and metallic of its PBR extension."""
    red, green, blue, opacity = described.rgba or (0.8, 0.8, 0.8, 1.0)
    lines = [
        f"newmtl {described.name}",
        f"Kd {red!r} {green!r} {blue!r}",
        f"d {opacity!r}",
        f"Pr {material.roughness!r}",
        f"Pm {material.metallic!r}",
    ]
    if described.texture:
        lines.append(f"map_Kd {PurePosixPath(described.texture).name}")
    return "\n".join(lines) + "\n"


def _losses(used: MeshMaterial) -> Iterator[Diagnostic]:
    """One finding for the fields of a material that the files do not hold, one for how its picture is read."""
    material = used.material
    where = Location(prim=used.prim_name)
    names = sorted(_lost_fields(material))
    if names:
        headline = f"material '{material.name}' is written without {', '.join(names)}"
        yield finding("asset/export-loss", headline, where=where, value=len(names), unit="values")
    use = material.base_color_texture
    if use is None:
        return
    ways = [f"wrap {way}" for way in dict.fromkeys((use.wrap_s, use.wrap_t)) if way != "repeat"]
    ways += ["a factor or an offset of its values"] * ((use.scale, use.bias) != (1.0, 0.0))
    ways += [f"its channel {use.channel} alone"] * (use.channel != "rgb")
    if ways:
        headline = f"the picture of material '{material.name}' is written without {', '.join(ways)}"
        yield finding("asset/export-loss", headline, where=where)


def _lost_fields(material: Material) -> Iterator[str]:
    """Names of the fields with a value other than their default that the files do not hold."""
    for entry in fields(material):
        value, plain = getattr(material, entry.name), getattr(_PLAIN, entry.name)
        needs = _WITHOUT_EFFECT.get(entry.name)
        silent = needs is not None and getattr(material, needs) == getattr(_PLAIN, needs)
        blended = entry.name == "alpha_mode" and value == "blend"  # that is what an opacity below 1 means there
        if entry.name not in _WRITTEN and value != plain and not silent and not blended:
            yield entry.name


def _mesh_losses(mesh: Mesh, used: MeshMaterial) -> Iterator[Diagnostic]:
    """What an OBJ file does not hold of one mesh."""
    where = Location(mesh=mesh.id)
    if used.vertex_colors:
        yield finding(
            "asset/export-loss", f"mesh '{mesh.id}' is written without the colours of its points", where=where
        )
    used_sets = {use.uv_set for use in used.material.texture_uses.values()}
    if len(mesh.uvs) > 1 and len(used_sets) > 1:
        headline = f"mesh '{mesh.id}' is written with one of its {len(mesh.uvs)} sets of texture coordinates"
        yield finding("asset/export-loss", headline, where=where, value=1, bound=len(mesh.uvs), unit="sets")
