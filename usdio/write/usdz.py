"""Packs a package's USD as one USDZ file: the layers without their MDL surfaces, the textures, nothing else.

USDZ allows USD, PNG, JPEG, EXR, AVIF and audio files alone (USDZ specification 1.3, File types), so MDL modules cannot
go along; UsdPreviewSurface and MaterialX surfaces of the same materials do.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from pxr import Sdf, UsdUtils

from schemas.diagnostics import InvalidInput, Location, finding
from usdio.quiet import quiet
from usdio.write.materials.modules import MODULE_FOLDER

_EPOCH_S = 315532800  # 1980-01-01, the first day that ZIP archives can hold: no clock reaches the file
_LAYERS = (".usda", ".usdc", ".usd")


def write_usdz(main_file: Path, target: Path) -> tuple[str, ...]:
    """Write `target` from the main USD file of a package; returns the materials whose MDL surface it lacks.

    The same package gives the same bytes. Raises InvalidInput `asset/package-invalid` when OpenUSD cannot pack it.
    """
    with quiet(), tempfile.TemporaryDirectory(prefix="mana") as place:
        copy = Path(place) / main_file.parent.name
        ignored = shutil.ignore_patterns(MODULE_FOLDER, ".thumbs")
        shutil.copytree(main_file.parent, copy, ignore=ignored)
        lost = sorted({name for file in sorted(copy.rglob("*")) if file.suffix in _LAYERS for name in _strip(file)})
        for file in copy.rglob("*"):
            os.utime(file, (_EPOCH_S, _EPOCH_S))
        packed = Path(place) / target.name
        if not UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(copy / main_file.name)), str(packed)):
            where = Location(file=main_file.name)
            raise InvalidInput(finding("asset/package-invalid", "OpenUSD cannot pack it as USDZ", where=where))
        shutil.copyfile(packed, target)
    return tuple(lost)


def _strip(file: Path) -> list[str]:
    """Remove MDL surfaces from a layer; returns the names of their materials."""
    layer = Sdf.Layer.FindOrOpen(str(file))
    names: list[str] = []
    shaders: list[Sdf.Path] = []

    def visit(path: Sdf.Path) -> None:
        if not path.IsPrimPath():
            return
        prim = layer.GetPrimAtPath(path)
        if "info:mdl:sourceAsset" in prim.properties:
            shaders.append(path)
        if "outputs:mdl:surface" in prim.properties:
            names.append(prim.name)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    if not names and not shaders:
        return []
    for path in shaders:
        parent = layer.GetPrimAtPath(path.GetParentPath())
        del parent.nameChildren[path.name]
    for path in {shader.GetParentPath() for shader in shaders}:
        material = layer.GetPrimAtPath(path)
        for name in [p.name for p in material.properties if p.name.startswith("outputs:mdl:")]:
            del material.properties[name]
    layer.Save()
    return names
