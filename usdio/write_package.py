"""Write one released package: main USD file, payload layers, textures, thumbnail (design: asset package)."""

from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics

from schemas.package import PackageContent
from usdio.looks import looks_per_mesh
from usdio.names import identifier
from usdio.write_materials import author_materials, texture_files
from usdio.write_meshes import author_meshes
from usdio.write_physics import author_body, author_colliders, author_contact_material

USD_FOLDER = "usd"
UNKNOWN = "unknown"
# What is true of every asset: Wikidata's "object". SL.* and SR.004 demand a label and a Q-code even when nobody
# knows what the thing is; the category field still says "unknown".
OBJECT_LABEL, OBJECT_QCODE = "object", "Q488383"
_DEFAULT_EPOCH_S = 315532800  # 1980-01-01, the first day ZIP archives can hold; no clock is ever read.


def write_package(content: PackageContent, folder: Path) -> Path:
    """Write `<folder>/usd/<asset_id>.usda` with its support files and return it.

    `folder` must be named so that `asset_id` contains the name (NP.005) and should be empty. Payload layers go to
    `payloads/`, the original bytes of the used textures to `textures/`, the thumbnail to `.thumbs/256x256/`.
    The same content gives the same bytes; dates come from SOURCE_DATE_EPOCH. Raises OSError when writing fails and
    ValueError for content that breaks its own contract (a hull without points).
    """
    main_file = folder / USD_FOLDER / f"{content.asset_id}.usda"
    payloads = main_file.parent / "payloads"
    textures = main_file.parent / "textures"
    payloads.mkdir(parents=True, exist_ok=True)
    root = Sdf.Path.absoluteRootPath.AppendChild(identifier(content.asset_id, "asset"))
    label = content.physical_material or UNKNOWN
    looks = looks_per_mesh(content.model)
    files = texture_files(content.model, looks)

    meshes = _new_stage(root)
    taken = author_meshes(meshes, root, content.model, looks)
    materials = _new_stage(root)
    author_materials(materials, root, looks, {name: f"../textures/{file}" for name, file in files.items()}, label)
    physics = _new_stage(root)
    contact = author_contact_material(physics, root, content.contact, content.density_kgm3, label)
    author_colliders(physics, root, content.shapes, contact, taken)

    layers = {f"{content.asset_id}_meshes.usdc": meshes, f"{content.asset_id}_materials.usda": materials}
    layers[f"{content.asset_id}_physics.usda"] = physics
    for name, stage in layers.items():
        _export(stage, payloads / name)
    _export(_main_stage(content, root, tuple(layers)), main_file)

    if files:
        textures.mkdir(exist_ok=True)
    data = {texture.name: texture.data for texture in content.model.textures}
    for name, file in files.items():
        (textures / file).write_bytes(data[name])
    thumbnail = main_file.parent / ".thumbs" / "256x256" / f"{main_file.name}.png"
    thumbnail.parent.mkdir(parents=True, exist_ok=True)
    thumbnail.write_bytes(content.thumbnail_png)
    return main_file


def _main_stage(content: PackageContent, root: Sdf.Path, layers: tuple[str, ...]) -> Usd.Stage:
    """The root layer: units, provenance, body and labels; everything else is a payload."""
    stage = _new_stage(root)
    prim = stage.GetDefaultPrim()
    author_body(prim, content.mass)
    Usd.ModelAPI(prim).SetKind(Kind.Tokens.component)
    Usd.ModelAPI(prim).SetAssetName(content.asset_id)
    known = content.category not in ("", UNKNOWN)
    UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr([content.category if known else OBJECT_LABEL])
    UsdSemantics.LabelsAPI.Apply(prim, "wikidata_qcode").CreateLabelsAttr([_qcode(content)])
    stage.GetRootLayer().customLayerData = {"SimReady_Metadata": _metadata(content)}
    spec = stage.GetRootLayer().GetPrimAtPath(root)
    spec.payloadList.prependedItems = [Sdf.Payload(f"./payloads/{name}") for name in layers]
    return stage


def _metadata(content: PackageContent) -> dict[str, object]:
    """The provenance fields of SR.004; what nobody knows is "unknown"."""
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
        "rigid_body_count": 1,
        "asset_extents": Gf.Vec3f(*(float(v) for v in extent)),
        "mass": float(content.mass.mass_kg),
    }


def _qcode(content: PackageContent) -> str:
    digits = content.qcode[1:]
    return content.qcode if content.qcode[:1] == "Q" and digits.isascii() and digits.isdigit() else OBJECT_QCODE


def _new_stage(root: Sdf.Path) -> Usd.Stage:
    """An empty in-memory stage with units, axis and default prim. Nothing is loaded: payload paths do not exist yet."""
    stage = Usd.Stage.CreateInMemory(load=Usd.Stage.LoadNone)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, root).GetPrim())
    return stage


def _export(stage: Usd.Stage, path: Path) -> None:
    if not stage.GetRootLayer().Export(str(path)):
        raise OSError(f"USD could not write {path.name}")
