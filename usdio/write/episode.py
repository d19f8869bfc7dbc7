"""Writes a variant of a recording as a USD stage: recorded motion as time samples, inserted objects as a layer.

`replay.usda` has two sublayers: `context.usda` (inserted objects, lights) over `motion.usdc` (recorded bodies and
cameras). One time code is one second: the time code of a sample equals its time stamp, bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from schemas.arrays import FloatArray
from schemas.identifiers import unique_identifiers
from schemas.physics import CollisionShape
from schemas.scene.compiled import PlacedObject
from schemas.scene.samples import SampledLighting
from usdio.write.physics import author_contact_material, author_shape
from usdio.write.primitive import CONTACT, DENSITY_KGM3
from usdio.write.sample import SampleEdit, author_sampled_lighting, bind_sampled_material
from usdio.write.scene import PACKAGES, author_lights, author_object, author_physics_scene, copy_package, main_file

REPLAY, MOTION, CONTEXT = "replay.usda", "motion.usdc", "context.usda"
INSERTED = Sdf.Path("/World/Inserted")
_ROOT = Sdf.Path("/World")
_APERTURE = 0.24  # Height of the film: 24 mm in tenths of a metre, as UsdGeomCamera counts.
_NEAR_FAR_M = (0.01, 1000.0)
# Linear RGB: robots light grey, handled objects orange, fixtures warm grey.
COLORS = {"Robots": (0.72, 0.74, 0.77), "Objects": (0.85, 0.32, 0.06), "Fixtures": (0.42, 0.38, 0.33)}


@dataclass(frozen=True)
class TimedBody:
    """A recorded body: X_WB (n, 4, 4) at the stamps, or (1, 4, 4) when static; shapes in B.

    `group` is Robots, Objects or Fixtures; `owner` the robot that a link belongs to, else empty.
    """

    group: str
    owner: str
    name: str
    shapes: tuple[CollisionShape, ...]
    X_WB: FloatArray


@dataclass(frozen=True)
class TimedCamera:
    """A recorded camera that looks along -z with +y up: X_WC (n, 4, 4), vertical field of view, picture size."""

    name: str
    X_WC: FloatArray
    fovy_rad: float
    width_px: int
    height_px: int


@dataclass(frozen=True)
class InsertedObject:
    """An inserted static object, and the edit that its sampled material requires."""

    item: PlacedObject
    edit: SampleEdit | None = None


def write_replay(folder: Path, t_s: FloatArray, about: dict[str, str | int]) -> Path:
    """`replay.usda`: the stage over both layers, from the first stamp of t_s (n,) to the last.

    USD keeps one sample for each time code: of rows with the same stamp the last counts. The indices of the
    dropped rows are in `mana:rowsBehindTheSameStamp` of the layer's custom data, beside `about`.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.subLayerPaths = [f"./{CONTEXT}", f"./{MOTION}"]
    _conventions(layer)
    layer.startTimeCode, layer.endTimeCode = float(t_s[0]), float(t_s[-1])
    steps = np.diff(t_s)
    if (steps > 0.0).any():
        layer.framesPerSecond = float(round(1.0 / np.median(steps[steps > 0.0]), 3))
    dropped_rows = Vt.IntArray(np.flatnonzero(np.append(steps == 0.0, False)).tolist())
    data = {f"mana:{key}": about[key] for key in sorted(about)}
    layer.customLayerData = {**data, "mana:rows": len(t_s), "mana:rowsBehindTheSameStamp": dropped_rows}
    return _saved(layer, folder / REPLAY)


def write_motion(folder: Path, t_s: FloatArray, bodies: Sequence[TimedBody], cameras: Sequence[TimedCamera]) -> Path:
    """`motion.usdc`: `/World/Robots/<robot>/<link>`, `/World/Objects`, `/World/Fixtures`, `/World/Cameras`.

    Every pose is one matrix in W, double precision. Moving bodies are kinematic, fixtures are static colliders; the
    collision shapes of the recording are also the drawn ones.
    """
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    stage = Usd.Stage.Open(layer)
    _conventions(layer)
    contact = author_contact_material(stage, _world(stage), CONTACT, DENSITY_KGM3, "unknown")
    times = t_s.tolist()
    for (group, owner), path in _scopes(stage, bodies).items():
        members = [body for body in bodies if (body.group, body.owner) == (group, owner)]
        for name, body in zip(unique_identifiers([b.name for b in members], "body"), members, strict=True):
            prim = _author_pose(UsdGeom.Xform.Define(stage, path.AppendChild(name)), times, body.X_WB, body.name)
            _author_shapes(stage, prim, body, contact)
    lenses = _group(stage, _ROOT.AppendChild("Cameras"))
    for name, camera in zip(unique_identifiers([c.name for c in cameras], "camera"), cameras, strict=True):
        lens = UsdGeom.Camera.Define(stage, lenses.AppendChild(name))
        _author_pose(lens, times, camera.X_WC, camera.name)
        lens.CreateVerticalApertureAttr(_APERTURE)
        lens.CreateHorizontalApertureAttr(_APERTURE * camera.width_px / camera.height_px)
        lens.CreateFocalLengthAttr(_APERTURE / 2.0 / math.tan(camera.fovy_rad / 2.0))
        lens.CreateClippingRangeAttr(Gf.Vec2f(*_NEAR_FAR_M))
        size = {"width_px": camera.width_px, "height_px": camera.height_px, "fovy_rad": float(camera.fovy_rad)}
        lens.GetPrim().SetCustomDataByKey("mana:picture", size)
    return _saved(layer, folder / MOTION)


def write_context(
    folder: Path, inserted: Sequence[InsertedObject], lighting: SampledLighting | None, library: Path
) -> Path:
    """`context.usda`: the inserted objects below `/World/Inserted`, sampled lights; packages are copied beside.

    The layer also opens alone. Raises FileNotFoundError for a package that is not in `library`.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    _conventions(layer)
    world = _world(stage)
    author_physics_scene(stage)
    author_lights(stage)
    if lighting is not None:
        author_sampled_lighting(stage, lighting)
    contact = author_contact_material(stage, world, CONTACT, DENSITY_KGM3, "inline")
    group = _group(stage, INSERTED)
    paths = [group.AppendChild(name) for name in inserted_prims([entry.item.id for entry in inserted])]
    for path, entry in zip(paths, inserted, strict=True):
        package = entry.item.package
        if package is not None:
            copy_package(library / package, folder / PACKAGES / package)
        author_object(stage, path, entry.item, contact, folder, moves=False)
        if entry.edit is not None and entry.edit.material is not None:
            bind_sampled_material(stage, stage.GetPrimAtPath(path), entry.edit.material, entry.edit)
    del stage  # A live stage would resolve the packages at once, relative to the anonymous layer.
    for path, entry in zip(paths, inserted, strict=True):
        if entry.item.package is not None:
            main = f"./{main_file(folder, entry.item.package).relative_to(folder).as_posix()}"
            layer.GetPrimAtPath(path).referenceList.prependedItems = [Sdf.Reference(main)]
    return _saved(layer, folder / CONTEXT)


def inserted_prims(names: Sequence[str]) -> list[str]:
    """The prim names below `/World/Inserted` of inserted objects of these names."""
    return list(unique_identifiers(names, "object"))


def _conventions(layer: Sdf.Layer) -> None:
    """Units, up axis and time codes of a layer; USD rescales the time of a layer whose time codes per second differ."""
    root = layer.pseudoRoot
    root.SetInfo("metersPerUnit", 1.0)
    root.SetInfo("kilogramsPerUnit", 1.0)
    root.SetInfo("upAxis", "Z")
    layer.timeCodesPerSecond = 1.0
    layer.defaultPrim = _ROOT.name


def _world(stage: Usd.Stage) -> Sdf.Path:
    world = UsdGeom.Xform.Define(stage, _ROOT).GetPrim()
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
    return world.GetPath()


def _group(stage: Usd.Stage, path: Sdf.Path) -> Sdf.Path:
    Usd.ModelAPI(UsdGeom.Xform.Define(stage, path).GetPrim()).SetKind(Kind.Tokens.group)
    return path


def _scopes(stage: Usd.Stage, bodies: Sequence[TimedBody]) -> dict[tuple[str, str], Sdf.Path]:
    """The prim that holds the bodies of a group and owner."""
    scopes = {}
    for group in dict.fromkeys(body.group for body in bodies):
        path = _group(stage, _ROOT.AppendChild(group))
        owners = list(dict.fromkeys(body.owner for body in bodies if body.group == group))
        for name, owner in zip(unique_identifiers(owners, "robot"), owners, strict=True):
            scopes[group, owner] = _group(stage, path.AppendChild(name)) if owner else path
    return scopes


def _author_pose(form: UsdGeom.Xformable, times: Sequence[float], X_W: FloatArray, name: str) -> Usd.Prim:
    """Author one matrix for each stamp, or one when static; transposed, because USD uses row vectors.

    Samples are set in one change block: change notices would take most of the time.
    """
    prim = form.GetPrim()
    attribute = form.AddTransformOp(UsdGeom.XformOp.PrecisionDouble).GetAttr()
    matrices = Vt.Matrix4dArray.FromNumpy(np.ascontiguousarray(X_W.transpose(0, 2, 1)))
    attribute.Set(matrices[0])
    if np.ptp(X_W, axis=0).any():
        layer, path = prim.GetStage().GetRootLayer(), attribute.GetPath()
        with Sdf.ChangeBlock():
            attribute.Clear()
            for time, matrix in zip(times, matrices, strict=True):
                layer.SetTimeSample(path, time, matrix)
    prim.SetCustomDataByKey("mana:id", name)
    return prim


def _author_shapes(stage: Usd.Stage, prim: Usd.Prim, body: TimedBody, contact: Sdf.Path) -> None:
    if not body.shapes:
        return
    Usd.ModelAPI(prim).SetKind(Kind.Tokens.component)
    if body.group != "Fixtures":
        api = UsdPhysics.RigidBodyAPI.Apply(prim)
        api.CreateRigidBodyEnabledAttr(True)
        api.CreateKinematicEnabledAttr(True)
    taken: set[bytes] = set()
    for index, shape in enumerate(body.shapes):
        drawn = author_shape(stage, prim.GetPath().AppendChild(f"shape_{index:02d}"), shape, taken)
        UsdGeom.Gprim(drawn).CreateDisplayColorAttr([Gf.Vec3f(*COLORS[body.group])])
        binding = UsdShade.MaterialBindingAPI.Apply(drawn)
        binding.Bind(UsdShade.Material.Get(stage, contact), materialPurpose="physics")


def _saved(layer: Sdf.Layer, file: Path) -> Path:
    if not layer.Export(str(file)):
        raise OSError(f"USD could not write {file.name}")
    return file
