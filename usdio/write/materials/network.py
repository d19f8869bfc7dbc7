"""Shaders of one UsdShade material while they are authored, in one render context."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pxr import Gf, Sdf, Usd, UsdShade

from schemas.appearance.material import Texture
from usdio.write.materials.modules import MODULE_FILES

Types = Sdf.ValueTypeNames
IDENTITY_UV = ((1.0, 1.0), 0.0, (0.0, 0.0))


@dataclass(frozen=True)
class TextureFiles:
    """The asset paths of textures, relative to the layer, and the textures themselves, both by Texture.name.

    `modules` is the path of the folder of MDL modules, relative to the layer.
    """

    paths: Mapping[str, str]
    images: Mapping[str, Texture]
    modules: str


@dataclass(frozen=True)
class Network:
    """Shader prims below `material`, their names beginning with `prefix`; equal nodes are authored once."""

    stage: Usd.Stage
    material: UsdShade.Material
    files: TextureFiles
    prefix: str = ""
    _shared: dict[tuple[object, ...], UsdShade.Shader] = field(
        default_factory=dict[tuple[object, ...], UsdShade.Shader]
    )

    def shader(self, name: str, identifier: str) -> UsdShade.Shader:
        """A new shader prim of a registered implementation."""
        shader = self._define(name)
        shader.CreateIdAttr(identifier)
        return shader

    def module(self, material: str) -> UsdShade.Shader:
        """A new shader prim whose implementation is the variant of an MDL material of the library."""
        shader = self._define("surface")
        shader.CreateImplementationSourceAttr(UsdShade.Tokens.sourceAsset)
        shader.SetSourceAsset(Sdf.AssetPath(f"{self.files.modules}/{MODULE_FILES[material]}"), "mdl")
        shader.SetSourceAssetSubIdentifier(material, "mdl")
        return shader

    def once(self, key: tuple[object, ...], author: Callable[[], UsdShade.Shader]) -> UsdShade.Shader:
        """The shader under `key`, authored on first use."""
        if key not in self._shared:
            self._shared[key] = author()
        return self._shared[key]

    def connect_surface(self, shader: UsdShade.Shader, output: str, context: str) -> None:
        """Make `output` of `shader` the surface of the material in a render context ("" is the universal one)."""
        port = shader.CreateOutput(output, Types.Token)
        surface = self.material.CreateSurfaceOutput(context) if context else self.material.CreateSurfaceOutput()
        surface.ConnectToSource(port)

    def _define(self, name: str) -> UsdShade.Shader:
        path = self.material.GetPath()
        taken = [
            n for n in range(1, 100) if self.stage.GetPrimAtPath(path.AppendChild(_numbered(self.prefix + name, n)))
        ]
        return UsdShade.Shader.Define(self.stage, path.AppendChild(_numbered(self.prefix + name, len(taken) + 1)))


def set_input(shader: UsdShade.Shader, name: str, kind: Sdf.ValueTypeName, value: object) -> UsdShade.Input:
    """Author one constant input; tuples become vectors of single precision."""
    port = shader.CreateInput(name, kind)
    vectors = {2: Gf.Vec2f, 3: Gf.Vec3f, 4: Gf.Vec4f}
    port.Set(vectors[len(value)](*value) if isinstance(value, tuple) else value)
    return port


def set_file(shader: UsdShade.Shader, name: str, path: str, color_space: str) -> None:
    """Author an image file with the colour space of its texels as metadata of the input."""
    port = set_input(shader, name, Types.Asset, Sdf.AssetPath(path))
    port.GetAttr().SetColorSpace(color_space)


def _numbered(name: str, number: int) -> str:
    return name if number == 1 else f"{name}_{number}"
