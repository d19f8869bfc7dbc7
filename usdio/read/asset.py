"""Reads a foreign USD asset into a `Model` in the stage's own units: pins its layers, composes, converts meshes,
materials and physics."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Pcp, Tf, Usd, UsdGeom, UsdPhysics

from formats.missing_limits import with_missing_limits
from schemas.diagnostics import Diagnostic, InvalidInput, Location, Severity, finding
from schemas.mechanism import Mechanism
from schemas.model import Mesh, Model, Node
from schemas.outcome import INTAKE, Outcome, Repair
from usdio.quiet import quiet
from usdio.read import stage_metadata
from usdio.read.gprim_mesh import GprimMesh, submesh, transformed
from usdio.read.gprim_placement import PlacedGprim, StageGprims, find_gprims
from usdio.read.layer_guard import PinnedLayers, check_layers, message
from usdio.read.materials import LoadTexture, MaterialTable
from usdio.read.mechanism import StageMechanism, stage_mechanism
from usdio.read.meshes import IMPLICIT_SHAPES, UNSUPPORTED, read_implicit_shape, read_mesh
from usdio.read.physics import stated_physics

_CYCLES: Final = (Pcp.ErrorType_ArcCycle, Pcp.ErrorType_SublayerCycle)


def read_stage(
    path: Path,
    root: Path,
    *,
    load_texture: LoadTexture,
    visited: set[Path] | None = None,
    missing: set[str] | None = None,
    mechanism: bool = True,
) -> Outcome[Model]:
    """The model in a USD, USDA, USDC or USDZ file, world transforms applied, in the stage's own units and axes.

    `visited` collects the files that references resolve to, `missing` the paths below the root that do not exist.
    `load_texture(data, name, *, where)` decodes image bytes and returns the texture or None, with findings. No file
    outside `root` is opened and nothing is printed. Variants stay as selected; values are those of the first sample.
    Without `mechanism` joints are not read: what the stage shows, of however many objects, is one rigid model.

    Raises InvalidInput as `check_layers`, `read_mesh`, `find_gprims` and `meters_per_unit` do, and
    `asset/missing-dependency` (without an absent layer no geometry is left), `asset/no-faces`, `asset/empty-geometry`,
    `asset/schema-error` for values that OpenUSD itself refuses.
    """
    with quiet():
        try:
            layers = check_layers(path, root)
            outcome = _read(layers, load_texture, mechanism)
            location = layers.location_of(layers.root)
            if visited is not None:
                visited |= location.visited
            if missing is not None:
                missing |= location.missing
            return outcome
        except Tf.ErrorException as error:
            headline, reason = "OpenUSD refuses a value in the file", message(error).rpartition(" : ")[2].strip("' \n")
            reason = reason.replace(f"{root.resolve()}/", "")
        except UnicodeDecodeError as error:
            headline, reason = "a text in the file is not UTF-8", error.reason
    where = Location(file=path.resolve().relative_to(root.resolve()).as_posix())
    raise InvalidInput(finding("asset/schema-error", headline, where=where, value=reason[:300]))


def _read(layers: PinnedLayers, load_texture: LoadTexture, with_mechanism: bool) -> Outcome[Model]:
    stage = Usd.Stage.Open(layers.root, Usd.Stage.LoadAll)
    where = layers.location_of(layers.root).where()
    composed = _composition(stage, layers)
    unit, axis = stage_metadata.meters_per_unit(stage, where), stage_metadata.up_axis(stage, where)
    start = stage_metadata.start_prim(stage, where)
    gprims = find_gprims(start.value, layers)
    table = MaterialTable(layers, load_texture)
    shapes = _shapes(gprims, table, where)
    if not shapes.value:
        raise InvalidInput(_no_surface(gprims, composed.diagnostics, where))
    masses, contacts = stated_physics(stage, start.value, shapes.value, where)
    moving = stage_mechanism(stage, shapes.value, where) if with_mechanism else None
    meshes, mechanism, slides = _linked(shapes.value, moving)
    model = Model(
        meshes=meshes,
        materials=tuple(entry.material for entry in table.entries),
        textures=tuple(table.textures),
        nodes=_with_meshes(gprims.nodes, shapes.value),
        meters_per_unit=unit.value,
        up_axis=axis.value,
        hints=(*stage_metadata.hints(stage, start.value), *_subdivision_hints(gprims)),
        metadata=stage_metadata.metadata(stage, start.value),
        masses=masses,
        contacts=contacts,
        mechanism=mechanism,
    )
    parts = (composed, unit, axis, start, shapes)
    diagnostics = [d for part in parts for d in part.diagnostics] + table.diagnostics
    diagnostics += stage_metadata.layer_contradictions(layers, where)
    diagnostics += _unsupported_prims(gprims, where)
    diagnostics += [*_animation(gprims, where), *_clips(layers)]
    diagnostics += moving.reading.notes if moving is not None else _articulation(stage, where)
    repairs = [r for part in parts for r in part.repairs] + table.repairs
    repairs += [*(moving.reading.repairs if moving else ()), *slides]
    return Outcome(model, tuple(diagnostics), tuple(repairs))


def _linked(
    meshes: tuple[Mesh, ...], moving: StageMechanism | None
) -> tuple[tuple[Mesh, ...], Mechanism | None, tuple[Repair, ...]]:
    """The meshes with their links, and the mechanism whose sliding joints all end somewhere."""
    if moving is None or moving.reading.mechanism is None:
        return meshes, None, ()
    linked = [replace(m, link=moving.link_of[m.source_path]) for m in meshes if m.source_path in moving.link_of]
    mechanism, repairs = with_missing_limits(moving.reading.mechanism, linked)
    return tuple(linked), mechanism, repairs


def _composition(stage: Usd.Stage, layers: PinnedLayers) -> Outcome[None]:
    """Composition errors: absent layers that the selected variants need, references to absent prims.

    Raises InvalidInput `asset/cyclic-reference` when arcs run in a circle.
    """
    where = layers.location_of(layers.root).where()
    notes: dict[str, Diagnostic] = {}
    for error in stage.GetCompositionErrors():
        text = str(error)
        if error.errorType in _CYCLES:
            prims = " > ".join(dict.fromkeys(re.findall(r"@<(/[^>]*)>", text)))
            raise InvalidInput(
                finding("asset/cyclic-reference", "references run in a circle", where=where, value=prims)
            )
        missing = next((name for name in layers.absent if f"@{name}@" in text), None)
        if missing is not None:
            notes[missing] = layers.absent[missing]
        elif error.errorType == Pcp.ErrorType_UnresolvedPrimPath:
            prim = re.search(r"@<(/[^>]*)>\s*introduced", text)
            headline = f"a reference names prim '{prim[1] if prim else '?'}', which does not exist; it was left out"
            notes[headline] = finding("asset/missing-dependency", headline, where=where, severity=Severity.WARNING)
    diagnostics = tuple(notes[key] for key in sorted(notes, key=lambda k: (notes[k].headline, k)))
    repairs = tuple(
        Repair(name="missing_dependency", code=d.code, stage=INTAKE, before={"reference": str(d.value or d.headline)})
        for d in diagnostics
    )
    return Outcome(None, diagnostics, repairs)


def _shapes(gprims: StageGprims, table: MaterialTable, where: Location) -> Outcome[tuple[Mesh, ...]]:
    """All meshes in the model frame, one per gprim and material; each prim is triangulated once."""
    meshes: list[Mesh] = []
    notes: list[Diagnostic] = []
    repairs: list[Repair] = []
    surfaces: dict[str, GprimMesh | None] = {}
    for item in gprims.placed:
        path = str(item.prim.GetPath())
        at = where.model_copy(update={"prim": path})
        if path not in surfaces:
            outcome = (read_implicit_shape if item.prim.GetTypeName() in IMPLICIT_SHAPES else read_mesh)(item.prim, at)
            surfaces[path] = outcome.value
            notes += outcome.diagnostics
        surface = surfaces[path]
        if surface is None:
            continue
        moved, replaced = transformed(surface, item.X_WP, at)
        if replaced:
            corners = moved.triangles.size
            headline = f"{replaced} of {corners} corner normals are zero or not finite"
            notes.append(finding("asset/bad-normals", headline, where=at, value=replaced, bound=0, unit="corners"))
            before: dict[str, float | int | str] = {"prim": path, "corners": corners, "bad_corners": replaced}
            repairs.append(Repair(name="bad_normals", code="asset/bad-normals", stage=INTAKE, before=before))
        meshes += _split(item, moved, table)
    return Outcome(tuple(meshes), tuple(notes), tuple(repairs))


def _split(item: PlacedGprim, surface: GprimMesh, table: MaterialTable) -> list[Mesh]:
    """One Mesh per material subset, and one for the faces that no subset claims."""
    free = np.ones(len(surface.triangles), dtype=bool)
    for _, rows in surface.subsets:
        free[rows] = False
    pieces = [(prim, f"_{prim.GetName()}", rows) for prim, rows in surface.subsets]
    if free.any():
        pieces.insert(0, (item.prim, "", np.flatnonzero(free)))
    copy = "" if item.copy is None else f"_{item.copy}"
    meshes: list[Mesh] = []
    for prim, suffix, rows in pieces:
        material = table.add(prim, surface.constant_color, double_sided=surface.double_sided)
        entry = None if material is None else table.entries[material]
        uv_names = entry.uv_names if entry else ()
        mesh = submesh(surface, rows, uv_names, colors=entry is None or entry.shows_mesh_colors)
        name = f"{item.prim.GetName()}{suffix}{copy}"
        meshes.append(replace(mesh, name=name, material=material, source_path=str(item.prim.GetPath())))
    return meshes


def _with_meshes(nodes: tuple[Node, ...], meshes: tuple[Mesh, ...]) -> tuple[Node, ...]:
    """`nodes`, each with the indices of the meshes read from its own prim."""
    owned: dict[str, list[int]] = {}
    for index, mesh in enumerate(meshes):
        owned.setdefault(mesh.source_path, []).append(index)
    return tuple(replace(node, meshes=tuple(owned.get(node.path, ()))) for node in nodes)


def _no_surface(gprims: StageGprims, absent: tuple[Diagnostic, ...], where: Location) -> Diagnostic:
    """Why the asset holds no surface at all."""
    if absent:
        headline = f"no geometry is left: {absent[0].headline}"
        return finding(
            "asset/missing-dependency", headline, where=absent[0].where, value=absent[0].value, because=absent
        )
    points = next((p.prim for p in gprims.placed if p.prim.GetAttribute("points").Get()), None)
    bare = points or next(iter(gprims.faceless), None)
    if bare:
        at = where.model_copy(update={"prim": str(bare.GetPath())})
        return finding("asset/no-faces", f"{bare.GetTypeName()} prims have no triangles to read", where=at)
    return finding("asset/empty-geometry", "the stage holds no surface", where=where)


def _unsupported_prims(gprims: StageGprims, where: Location) -> tuple[Diagnostic, ...]:
    """One finding that counts the prims without triangles; only `info` when all are curves and points."""
    kinds = Counter(str(prim.GetTypeName()) for prim in gprims.faceless)
    if not kinds:
        return ()
    listed = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    severity = None if set(kinds) & set(UNSUPPORTED) else Severity.INFO
    at = where.model_copy(update={"prim": str(gprims.faceless[0].GetPath())})
    headline = f"{listed}: prims without triangles were left out"
    return (finding("asset/geometry-left-out", headline, where=at, value=len(gprims.faceless), severity=severity),)


def _subdivision_hints(gprims: StageGprims) -> tuple[str, ...]:
    """A hint when a subdivision scheme is authored: the control cage was read."""
    for item in gprims.placed:
        scheme = UsdGeom.Mesh(item.prim).GetSubdivisionSchemeAttr() if item.prim.GetTypeName() == "Mesh" else None
        if scheme and scheme.HasAuthoredValue() and scheme.Get() != UsdGeom.Tokens.none:
            return (f"subdivisionScheme {scheme.Get()}: the control cage was read",)
    return ()


def _animation(gprims: StageGprims, where: Location) -> tuple[Diagnostic, ...]:
    if gprims.animated is None:
        return ()
    at = where.model_copy(update={"prim": str(gprims.animated.GetPath())})
    return (finding("asset/animation-dropped", "the stage is animated; its first sample was taken", where=at),)


def _clips(layers: PinnedLayers) -> tuple[Diagnostic, ...]:
    return tuple(
        finding("asset/animation-dropped", "value clips were left out", where=location.where())
        for location in layers.clips
    )


def _articulation(stage: Usd.Stage, where: Location) -> tuple[Diagnostic, ...]:
    """A warning that names joints between prims which are no rigid bodies, or bodies that a root alone connects."""
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    joints = [p for p in prims if p.IsA(UsdPhysics.Joint) and _bodies(p) == 2]
    roots = [p for p in prims if p.HasAPI(UsdPhysics.ArticulationRootAPI)]
    bodies = [p for p in prims if p.HasAPI(UsdPhysics.RigidBodyAPI)]
    if not joints and not (roots and len(bodies) > 1):
        return ()
    names = [str(p.GetPath()) for p in joints or roots]
    at = where.model_copy(update={"prim": names[0]})
    connected = "joints" if joints else "bodies under one articulation"
    headline = f"the source declares {len(joints) or len(bodies)} {connected}, which are not carried over"
    return (finding("asset/articulated-source", headline, where=at, value=", ".join(names)),)


def _bodies(prim: Usd.Prim) -> int:
    joint = UsdPhysics.Joint(prim)
    return sum(bool(rel.GetTargets()) for rel in (joint.GetBody0Rel(), joint.GetBody1Rel()))
