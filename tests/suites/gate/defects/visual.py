"""Defects of visible meshes, materials and textures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from tests.suites.gate.edits import (
    BASE,
    BODY_MESH,
    CABINET,
    DOOR,
    NAN,
    OAK,
    PROP,
    SURFACE,
    TYPES,
    Defect,
    Sound,
    cabinet,
    drop_faces,
    on_prim,
    points,
    prop,
    put,
    remove,
    reverse_faces,
    shader,
    target,
    texture_of,
    turn_inside_out,
)
from usdio.write.materials.modules import module_sources

PANEL, KNOB, TOP = f"{DOOR}/Visuals/panel", f"{DOOR}/Visuals/knob", f"{BASE}/Visuals/top"
MATERIAL = f"{CABINET}/Materials/oak"
PLACEMENT = SURFACE.replace("surface", "diffuseColor_placement")
SPACE = "inputs:sourceColorSpace"
OPEN_PBR, OMNI_PBR = SURFACE.replace("surface", "mtlx_surface"), SURFACE.replace("surface", "mdl_surface")
PICTURE = Sdf.AssetPath("./sample.png")


def _scale_normals(factor: float):
    def change(prim: Usd.Prim) -> None:
        normals = prim.GetAttribute("primvars:normals")
        normals.Set(Vt.Vec3fArray.FromNumpy(np.float32(factor) * np.array(normals.Get())))

    return change


def _stray_index(prim: Usd.Prim) -> None:
    indices = UsdGeom.Mesh(prim).GetFaceVertexIndicesAttr()
    indices.Set(Vt.IntArray([99, *list(indices.Get())[1:]]))


def _nan_coordinate(prim: Usd.Prim) -> None:
    coordinates = np.array(prim.GetAttribute("primvars:st").Get())
    coordinates[3] = NAN
    prim.GetAttribute("primvars:st").Set(Vt.Vec2fArray.FromNumpy(coordinates))


def _packed(prim: Usd.Prim) -> None:
    prim.GetAttribute("inputs:scale").Set(Gf.Vec4f(1))
    prim.GetAttribute("inputs:bias").Set(Gf.Vec4f(0))


def _corrupt_picture(stage: Usd.Stage) -> None:
    def cut(prim: Usd.Prim) -> None:
        path = prim.GetAttribute("inputs:file").Get().resolvedPath
        with open(path, "r+b") as file:
            file.truncate(20)

    texture_of("normal", cut)(stage)


def omni_pbr(name: str, value: object, kind: Sdf.ValueTypeName, module: str = "./mana_opaque.mdl", space: str = "raw"):
    """A sound OmniPBR shader in the prop's material, with its module and a picture, and one more input."""

    def edit(stage: Usd.Stage) -> None:
        folder = Path(stage.GetRootLayer().realPath).parent
        (folder / "mana_opaque.mdl").write_text(module_sources(["OmniPBR"])["mana_opaque.mdl"])
        Image.new("RGB", (2, 2)).save(folder / "sample.png")
        node = UsdShade.Shader.Define(stage, OMNI_PBR)
        node.SetSourceAsset(Sdf.AssetPath(module), "mdl")
        node.SetSourceAssetSubIdentifier("OmniPBR", "mdl")
        port = node.CreateInput(name, kind)
        port.Set(value)
        if kind == TYPES.Asset:
            port.GetAttr().SetColorSpace(space)
        surface = UsdShade.Material(node.GetPrim().GetParent()).CreateSurfaceOutput("mdl")
        surface.ConnectToSource(node.CreateOutput("out", TYPES.Token))

    return edit


def read_as(path: str, name: str, color_space: str):
    """The picture upstream of a MaterialX input, read in another colour space."""

    def change(prim: Usd.Prim) -> None:
        node = UsdShade.Shader(prim)
        while not node.GetInput("file"):
            ports = [node.GetInput(name)] if node.GetPath() == prim.GetPath() else node.GetInputs()
            sources = (port.GetConnectedSources()[0] for port in ports)
            node = UsdShade.Shader(next(found[0].source for found in sources if found).GetPrim())
        node.GetInput("file").GetAttr().SetColorSpace(color_space)

    return on_prim(path, change)


DEFECTS: tuple[Defect, ...] = (
    prop("visible mesh hidden", put(BODY_MESH, "visibility", "invisible"), "not-visible"),
    cabinet("one mesh hidden", put(KNOB, "visibility", "invisible"), "not-visible"),
    prop("visible meshes as guides", put(f"{PROP}/Visuals", "purpose", "guide"), "not-visible"),
    prop("index out of range", on_prim(BODY_MESH, _stray_index), "mesh-topology"),
    cabinet("counts disagree", put(PANEL, "faceVertexCounts", Vt.IntArray([3] * 11)), "mesh-topology"),
    prop("too few texture coordinates", put(BODY_MESH, "primvars:st", Vt.Vec2fArray(5)), "mesh-topology"),
    cabinet("NaN point", points(PANEL, lambda p: np.where(np.arange(len(p))[:, None] == 0, NAN, p)), "mesh-values"),
    prop("NaN texture coordinate", on_prim(BODY_MESH, _nan_coordinate), "mesh-values"),
    prop("extent of another mesh", put(BODY_MESH, "extent", Vt.Vec3fArray([(0, 0, 0), (9, 9, 9)])), "mesh-extent"),
    cabinet("extent too small", put(TOP, "extent", Vt.Vec3fArray([(0, 0, 0), (0.01, 0.01, 0.01)])), "mesh-extent"),
    cabinet("normals inwards", on_prim(TOP, _scale_normals(-1.0)), "normals"),
    prop("normals of length 10", on_prim(BODY_MESH, _scale_normals(10.0)), "normals"),
    prop("winding reversed", reverse_faces(BODY_MESH), "inverted-mesh"),
    prop("mesh inside out", turn_inside_out(BODY_MESH), "inverted-mesh"),
    cabinet("one board inside out", turn_inside_out(PANEL), "inverted-mesh"),
    cabinet("left-handed by mistake", put(KNOB, "orientation", "leftHanded"), "inverted-mesh"),
    prop("four faces turned round", reverse_faces(BODY_MESH, 4), "inverted-mesh"),
    prop("a third of the faces gone", drop_faces(BODY_MESH, slice(0, 8)), "open-mesh"),
    prop("one face gone", drop_faces(BODY_MESH, slice(1, None)), "open-mesh"),
    cabinet("a face gone, no record to compare", drop_faces(TOP, slice(2, None)), "open-mesh", "warning"),
    prop("binding to nothing", target(BODY_MESH, "material:binding", f"{PROP}/Materials/gone"), "material-binding"),
    cabinet("binding to no material", target(KNOB, "material:binding", BASE), "material-binding"),
    cabinet("unbound mesh", target(KNOB, "material:binding"), "material-binding"),
    cabinet(
        "surface not connected",
        on_prim(MATERIAL, lambda p: UsdShade.Material(p).GetSurfaceOutput().ClearSources()),
        "shader-network",
    ),
    cabinet("unknown surface shader", put(OAK, "info:id", "FancySurface"), "shader-network"),
    cabinet("shader without id", remove(OAK, "info:id"), "shader-network"),
    cabinet("roughness 7", shader(OAK, "roughness", 7.0, TYPES.Float), "shader-value"),
    prop("negative metallic", shader(SURFACE, "metallic", -1.0, TYPES.Float), "shader-value"),
    cabinet("colour of 255", shader(OAK, "diffuseColor", Gf.Vec3f(255, 128, 0), TYPES.Color3f), "shader-value"),
    prop("metallic 5 behind a texture", put(SURFACE, "inputs:metallic", 5.0), "shader-value", "warning"),
    prop("NaN texture rotation", put(PLACEMENT, "inputs:rotation", NAN), "shader-value"),
    prop("NaN opacity", shader(SURFACE, "opacity", NAN, TYPES.Float), "shader-value"),
    prop("ior 0.2", shader(SURFACE, "ior", 0.2, TYPES.Float), "shader-value"),
    prop("normal map in sRGB", texture_of("normal", lambda p: p.GetAttribute(SPACE).Set("sRGB")), "texture-reader"),
    prop("colour map raw", texture_of("emissiveColor", lambda p: p.GetAttribute(SPACE).Set("raw")), "texture-reader"),
    prop("normal map not unpacked", texture_of("normal", _packed), "texture-reader"),
    prop("node that MaterialX lacks", put(OPEN_PBR, "info:id", "ND_open_pbr_surface_v9"), "shader-node"),
    prop("input that OpenPBR lacks", shader(OPEN_PBR, "clearcoat", 0.5, TYPES.Float), "shader-node"),
    prop("weight as a colour", shader(OPEN_PBR, "subsurface_weight", Gf.Vec3f(1), TYPES.Color3f), "shader-node"),
    prop("parameter that OmniPBR lacks", omni_pbr("sheen_weight", 0.5, TYPES.Float), "shader-node"),
    prop("threshold as a flag", omni_pbr("flip_tangent_u", 1.0, TYPES.Float), "shader-node"),
    prop("module of the renderer", omni_pbr("bump_factor", 1.0, TYPES.Float, "OmniPBR.mdl"), "shader-node"),
    prop("OpenPBR colour as data", read_as(OPEN_PBR, "base_color", "none"), "texture-space"),
    prop("OpenPBR normals as colour", read_as(OPEN_PBR, "geometry_normal", "srgb_texture"), "texture-space"),
    prop(
        "OmniPBR normals as colour", omni_pbr("normalmap_texture", PICTURE, TYPES.Asset, space="sRGB"), "texture-space"
    ),
    prop("OmniPBR colour raw", omni_pbr("diffuse_texture", PICTURE, TYPES.Asset, space="raw"), "texture-space"),
    prop("OpenPBR roughness 3", shader(OPEN_PBR, "fuzz_roughness", 3.0, TYPES.Float), "shader-value"),
    prop("texture coordinates gone", remove(BODY_MESH, "primvars:st"), "texture-coordinates", "warning"),
    prop("texture cut short", _corrupt_picture, "texture-image"),
    prop("vendor value NaN", put(PROP, "physxRigidBody:maxDepenetrationVelocity", NAN, TYPES.Float), "nonfinite-value"),
)

SOUND: tuple[Sound, ...] = (
    Sound("rough surface", "prop", shader(SURFACE, "roughness", 1.0, TYPES.Float)),
    Sound("normals of OmniPBR as data", "prop", omni_pbr("normalmap_texture", PICTURE, TYPES.Asset)),
    Sound("colour of OmniPBR as sRGB", "prop", omni_pbr("diffuse_texture", PICTURE, TYPES.Asset, space="sRGB")),
    Sound("full coat of OpenPBR", "prop", shader(OPEN_PBR, "fuzz_weight", 1.0, TYPES.Float)),
)
