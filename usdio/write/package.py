"""Writes one released package from `PackageContent`: main USD file, payload layers, textures, thumbnail."""

from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics

from schemas.identifiers import identifier, unique_identifiers
from schemas.package import PackageContent
from schemas.physics import SurfaceMaterial
from usdio.write.bodies import package_bodies, place_body
from usdio.write.grasps import author_grasps
from usdio.write.joints import author_filtered_pairs, author_joints
from usdio.write.materials.author import author_materials, texture_files
from usdio.write.materials.mesh_materials import materials_per_mesh
from usdio.write.materials.modules import MODULE_FOLDER
from usdio.write.materials.network import TextureFiles
from usdio.write.meshes import author_meshes
from usdio.write.physics import author_body, author_colliders, author_contact_material

USD_FOLDER = "usd"
UNKNOWN = "unknown"
# Wikidata's "object", true of every asset. SL.* and SR.004 demand a label and a Q-code even when the category is not
# known; the category field still holds "unknown".
OBJECT_LABEL, OBJECT_QCODE = "object", "Q488383"
_DEFAULT_EPOCH_S = 315532800  # 1980-01-01, the first day ZIP archives can hold; no clock is ever read.


def write_package(content: PackageContent, folder: Path) -> Path:
    """Write `<folder>/usd/<asset_id>.usda` with its support files and return it.

    `folder` must be named so that `asset_id` contains the name (NP.005) and should be empty. Payload layers go to
    `payloads/`, the original bytes of the used textures to `textures/`, MDL modules to `mdl/`, the thumbnail to
    `.thumbs/256x256/`.
    The same content gives the same bytes; dates come from SOURCE_DATE_EPOCH. Raises OSError when writing fails and
    ValueError for content that breaks its own contract (a hull without points).
    """
    main_file = folder / USD_FOLDER / f"{content.asset_id}.usda"
    payloads = main_file.parent / "payloads"
    textures = main_file.parent / "textures"
    payloads.mkdir(parents=True, exist_ok=True)
    root = Sdf.Path.absoluteRootPath.AppendChild(identifier(content.asset_id, "asset"))
    label = content.physical_material or UNKNOWN
    mesh_materials = materials_per_mesh(content.model)
    files = texture_files(content.model, mesh_materials)

    meshes, materials, physics = _new_stage(root), _new_stage(root), _new_stage(root)
    bodies = package_bodies(content, root)
    frames = {body.link: body.frame for body in bodies}
    taken = author_meshes(meshes, root, content.model, mesh_materials, content.parts, frames)
    images = {texture.name: texture for texture in content.model.textures}
    paths = {name: f"../textures/{file}" for name, file in files.items()}
    looks = TextureFiles(paths, images, f"../{MODULE_FOLDER}")
    modules = author_materials(materials, root, mesh_materials, looks, label)
    contact_materials = _contact_materials(physics, root, content)
    for body in bodies:
        of_shapes = [contact_materials[i] for i in body.shape_indices]
        author_colliders(physics, body.frame.path, body.shapes, of_shapes, taken)
    if content.mechanism is not None:
        author_joints(physics, root, content.mechanism)
        author_filtered_pairs(physics, root, content.filtered_pairs)
    author_grasps(physics, root, content.grasp_lines_m)

    stem = content.asset_id
    _export(meshes.GetRootLayer(), payloads / f"{stem}_meshes.usdc")
    _export(materials.GetRootLayer(), payloads / f"{stem}_materials.usda")
    _export(physics.GetRootLayer(), payloads / f"{stem}_physics.usda")
    _export(_base_layer(root, stem), payloads / f"{stem}_base.usda")
    _export(_main_layer(content, root), main_file)

    if files:
        textures.mkdir(exist_ok=True)
    for name, file in files.items():
        (textures / file).write_bytes(images[name].data)
    for name, source in modules.items():
        (main_file.parent / MODULE_FOLDER).mkdir(exist_ok=True)
        (main_file.parent / MODULE_FOLDER / name).write_text(source)
    thumbnail = main_file.parent / ".thumbs" / "256x256" / f"{main_file.name}.png"
    thumbnail.parent.mkdir(parents=True, exist_ok=True)
    thumbnail.write_bytes(content.thumbnail_png)
    return main_file


def _contact_materials(stage: Usd.Stage, root: Sdf.Path, content: PackageContent) -> list[Sdf.Path]:
    """Author the contact materials, the principal one first, and return that of each shape."""
    label = content.physical_material or UNKNOWN
    surfaces = list(dict.fromkeys(content.surfaces)) or [SurfaceMaterial(label, content.density_kgm3, content.contact)]
    names = unique_identifiers([surface.label for surface in surfaces], UNKNOWN)
    paths = {
        surface: author_contact_material(stage, root, surface.contact, surface.density_kgm3, surface.label, name)
        for surface, name in zip(surfaces, names, strict=True)
    }
    if not content.shape_surfaces:
        return [paths[surfaces[0]]] * len(content.shapes)
    return [paths[content.surfaces[index]] for index in content.shape_surfaces]


def _base_layer(root: Sdf.Path, stem: str) -> Sdf.Layer:
    """The visual layers, without physics. ISA.001 requires base, meshes and physics layers by these names."""
    layer = _new_stage(root).GetRootLayer()
    names = (f"./{stem}_meshes.usdc", f"./{stem}_materials.usda")
    layer.GetPrimAtPath(root).referenceList.prependedItems = [Sdf.Reference(name) for name in names]
    return layer


def _main_layer(content: PackageContent, root: Sdf.Path) -> Sdf.Layer:
    """The root layer: units, provenance, body and labels; visuals and colliders are payloads."""
    stage = _new_stage(root)
    layer = stage.GetRootLayer()
    prim = stage.GetDefaultPrim()
    for body in package_bodies(content, root):
        author_body(place_body(stage, body), body.mass)
    if content.mechanism is not None:
        UsdPhysics.ArticulationRootAPI.Apply(prim)
    Usd.ModelAPI(prim).SetKind(Kind.Tokens.component)
    Usd.ModelAPI(prim).SetAssetName(content.asset_id)
    known = content.category not in ("", UNKNOWN)
    UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr([content.category if known else OBJECT_LABEL])
    UsdSemantics.LabelsAPI.Apply(prim, "wikidata_qcode").CreateLabelsAttr([_qcode(content)])
    metadata = _metadata(content)
    repeated = {key: metadata[key] for key in ("asset_name", "asset_type", "source_file", "usd_date_generated")}
    layer.customLayerData = {"SimReady_Metadata": metadata, **repeated}  # SR.001 and SR.004 require both
    del stage  # A live stage would resolve the payload files at once.
    names = (f"{content.asset_id}_base.usda", f"{content.asset_id}_physics.usda")
    layer.GetPrimAtPath(root).payloadList.prependedItems = [Sdf.Payload(f"./payloads/{name}") for name in names]
    return layer


def _metadata(content: PackageContent) -> dict[str, object]:
    """The provenance fields of SR.004; unknown values are "unknown"."""
    points = np.concatenate([mesh.points for mesh in content.model.meshes if len(mesh.points)])
    extent = np.ptp(points, axis=0)
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH", _DEFAULT_EPOCH_S))
    return {
        "asset_name": content.asset_id,
        "asset_type": "prop",
        "asset_license": content.license or UNKNOWN,
        "author": content.author or UNKNOWN,
        "category": content.category or UNKNOWN,
        "source_file": content.source_file or UNKNOWN,
        "usd_date_generated": datetime.fromtimestamp(seconds, UTC).date().isoformat(),
        "qcode": _qcode(content),
        "rigid_body_count": max(1, len(content.links)),
        "asset_extents": Gf.Vec3f(*(float(v) for v in extent)),
        "mass": float(content.mass.mass_kg),
    }


def _qcode(content: PackageContent) -> str:
    digits = content.qcode[1:]
    return content.qcode if content.qcode[:1] == "Q" and digits.isascii() and digits.isdigit() else OBJECT_QCODE


def _new_stage(root: Sdf.Path) -> Usd.Stage:
    """A stage of one layer in memory with units, axis and default prim."""
    stage = Usd.Stage.Open(Sdf.Layer.CreateAnonymous(".usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, root).GetPrim())
    return stage


def _export(layer: Sdf.Layer, path: Path) -> None:
    if not layer.Export(str(path)):
        raise OSError(f"USD could not write {path.name}")
