"""Mass and contact values of a foreign stage (UsdPhysics MassAPI, MaterialAPI), in the model frame, masses in kg."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, Final, get_args

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdPhysics

from geom.mass.principal_axes import inertia_from_principal, rotated_tensor
from geom.pose import apply
from schemas.diagnostics import Location
from schemas.model import Mesh
from schemas.stated_physics import Combine, StatedContact, StatedMass
from usdio.contact_material import bound_contact_material
from usdio.read.gprim_placement import column_matrix
from usdio.read.meshes import EARLIEST

_FRICTION_COMBINE: Final = "physxMaterial:frictionCombineMode"


def stated_physics(
    stage: Usd.Stage, start: Usd.Prim, meshes: Sequence[Mesh], where: Location
) -> tuple[tuple[StatedMass, ...], tuple[StatedContact, ...]]:
    """Mass and contact values of prims at or below `start` for `meshes`: world frame, stage units of length, kg.

    Zero means "not stated", as the schema defines; other values are passed on unchecked. A mass
    centre goes through the whole transform; a tensor is only turned, because UsdPhysics gives it in kg and stage
    units whatever the scale of its prim (`UsdPhysics.RigidBodyAPI.ComputeMassProperties` does the same).
    """
    reader = _Reader(start, meshes, where, kilograms_per_unit(stage))
    return tuple(reader.masses()), tuple(reader.contacts())


class _Reader:
    """The surfaces below `start` that were read as meshes, the hidden colliders, and the rigid body of each."""

    def __init__(self, start: Usd.Prim, meshes: Sequence[Mesh], where: Location, kilograms_per_unit: float) -> None:
        self._start = start
        self._where = where
        self._kilograms_per_unit = kilograms_per_unit
        self._triangles: dict[str, int] = {}
        for mesh in meshes:
            self._triangles[mesh.source_path] = self._triangles.get(mesh.source_path, 0) + len(mesh.triangles)
        prims = tuple(Usd.PrimRange(start, Usd.TraverseInstanceProxies()))
        # Values on prototypes of a point instancer hold for no single copy and are not read.
        self._surfaces = {str(p.GetPath()): p for p in prims if str(p.GetPath()) in self._triangles}
        self._hidden = [
            p for p in prims if p.HasAPI(UsdPhysics.CollisionAPI) and str(p.GetPath()) not in self._surfaces
        ]
        self._body = {path: self._body_of(prim) for path, prim in self._surfaces.items()}

    def masses(self) -> list[StatedMass]:
        """One statement per prim that states mass or density, over the surfaces it counts for.

        Precedence as UsdPhysics has it: the mass of an ancestor before that of a descendant, then the density nearest
        to the surface, then the density of its contact material. Never across the border of a rigid body.
        """
        sources: dict[str, tuple[Usd.Prim, list[str]]] = {}
        unstated: list[str] = []
        for path, prim in self._surfaces.items():
            source = self._source_of_mass(prim)
            if source is None:
                unstated.append(path)
            else:
                sources.setdefault(str(source.GetPath()), (source, []))[1].append(path)
        statements = [self._mass(source, covers) for source, covers in sources.values()]
        for body in dict.fromkeys(self._body[path] for path in unstated):
            hidden = self._mass_of_hidden(body, [path for path in unstated if self._body[path] == body])
            statements += [] if hidden is None else [hidden]
        return statements

    def contacts(self) -> list[StatedContact]:
        """One statement per contact material, over the surfaces whose colliders use it.

        A hidden collider counts for the surfaces below it, or else for all of its body.
        """
        covered_by = [(prim, [path]) for path, prim in self._surfaces.items()]
        for prim in self._hidden:
            below = [path for path in self._surfaces if path.startswith(f"{prim.GetPath()}/")]
            body = self._body_of(prim)
            covered_by.append((prim, below or [path for path in self._surfaces if self._body[path] == body]))
        materials: dict[str, tuple[Usd.Prim, dict[str, None]]] = {}
        for prim, covers in covered_by:
            material = contact_material(prim)
            if material is not None:
                materials.setdefault(str(material.GetPath()), (material, {}))[1].update(dict.fromkeys(covers))
        return [self._contact(material, tuple(covers)) for material, covers in materials.values() if covers]

    def _body_of(self, prim: Usd.Prim) -> Usd.Prim:
        """The rigid body that `prim` belongs to, else the start prim."""
        while prim != self._start and not prim.HasAPI(UsdPhysics.RigidBodyAPI):
            prim = prim.GetParent()
        return prim

    def _source_of_mass(self, prim: Usd.Prim) -> Usd.Prim | None:
        """The prim whose mass or density counts for the surface or collider `prim`."""
        body, chain = self._body_of(prim), [prim]
        while chain[-1] != body:
            chain.append(chain[-1].GetParent())
        stating = [p for p in chain if p.HasAPI(UsdPhysics.MassAPI)]
        heavy = [p for p in stating if authored_number(p, "mass")]
        dense = [p for p in stating if authored_number(p, "density")]
        if heavy or dense:
            return heavy[-1] if heavy else dense[0]
        material = contact_material(prim)
        return material if material is not None and authored_number(material, "density") else None

    def _mass_of_hidden(self, body: Usd.Prim, covers: Sequence[str]) -> StatedMass | None:
        """The mass from the hidden colliders of `body`, for surfaces without a statement of their own.

        Masses add up; densities count only when they agree, because it is unknown which surface is which collider.
        """
        sources = [self._source_of_mass(prim) for prim in self._hidden if self._body_of(prim) == body]
        distinct = {str(s.GetPath()): s for s in sources if s is not None}
        stated = [self._mass(source, covers) for source in distinct.values()]
        if not stated or None in sources:
            return None
        if all(s.mass_kg is not None for s in stated):
            return _summed(stated)
        return stated[0] if len({(s.mass_kg, s.density) for s in stated}) == 1 else None

    def _mass(self, prim: Usd.Prim, covers: Iterable[str]) -> StatedMass:
        covered = tuple(covers)
        statement = StatedMass(
            covers=covered,
            triangles=sum(self._triangles[path] for path in covered),
            method="UsdPhysics density",
            where=self._where.model_copy(update={"prim": str(prim.GetPath())}),
        )
        mass, density = authored_number(prim, "mass"), authored_number(prim, "density")
        if mass is None or not prim.HasAPI(UsdPhysics.MassAPI):
            return replace(statement, density=None if density is None else density * self._kilograms_per_unit)
        X_WP = column_matrix(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim))
        centre, inertia = authored_centre(prim), authored_inertia(prim)
        return replace(
            statement,
            method="UsdPhysics mass",
            mass_kg=mass * self._kilograms_per_unit,
            centre=None if centre is None else apply(X_WP, centre[None])[0],
            inertia=None if inertia is None else rotated_tensor(inertia, X_WP[:3, :3]) * self._kilograms_per_unit,
        )

    def _contact(self, material: Usd.Prim, covers: tuple[str, ...]) -> StatedContact:
        return StatedContact(
            covers=covers,
            name=material.GetName(),
            method="UsdPhysics material",
            where=self._where.model_copy(update={"prim": str(material.GetPath())}),
            static_friction=authored(material, "physics:staticFriction"),
            dynamic_friction=authored(material, "physics:dynamicFriction"),
            restitution=authored(material, "physics:restitution"),
            combine=combine_rule(material),
        )


def kilograms_per_unit(stage: Usd.Stage) -> float:
    """1 when the stage states no valid value."""
    try:
        value = float(UsdPhysics.GetStageKilogramsPerUnit(stage))
    except Tf.ErrorException:
        return 1.0
    return value if math.isfinite(value) and value > 0.0 else 1.0


def contact_material(prim: Usd.Prim) -> Usd.Prim | None:
    """The material bound to a collider, if it has contact values."""
    api = bound_contact_material(prim)
    return api.GetPrim() if api is not None and api.GetPrim().HasAPI(UsdPhysics.MaterialAPI) else None


def authored(prim: Usd.Prim, name: str) -> Any:
    """The value of an attribute, None where only its schema gives one."""
    attribute = prim.GetAttribute(name)
    return attribute.Get(EARLIEST) if attribute and attribute.HasAuthoredValue() else None


def authored_number(prim: Usd.Prim, name: str) -> float | None:
    """Mass or density as authored; zero means "not stated"."""
    value = authored(prim, f"physics:{name}")
    return float(value) if value else None


def authored_centre(prim: Usd.Prim) -> np.ndarray | None:
    """The authored mass centre in the prim's own frame; minus infinity means "not stated"."""
    value = authored(prim, "physics:centerOfMass")
    return None if value is None or np.isneginf(value).any() else np.asarray(value, dtype=np.float64)


def authored_inertia(prim: Usd.Prim) -> np.ndarray | None:
    """`R diag(diagonalInertia) R^T` in the prim's own frame; a zero diagonal means "not stated"."""
    moments = authored(prim, "physics:diagonalInertia")
    if moments is None or not np.any(moments):
        return None
    axes = authored(prim, "physics:principalAxes")
    quat_wxyz = np.zeros(4) if axes is None else np.array([axes.GetReal(), *axes.GetImaginary()], dtype=np.float64)
    if not np.any(quat_wxyz):
        quat_wxyz = np.array([1.0, 0.0, 0.0, 0.0])
    return inertia_from_principal(np.asarray(moments, dtype=np.float64), quat_wxyz)


def combine_rule(material: Usd.Prim) -> Combine:
    """The combine rule of the PhysX schema; UsdPhysics itself has none, and engines then take the average."""
    rules: dict[str, Combine] = {"min": "minimum", "max": "maximum", **{r: r for r in get_args(Combine)}}
    return rules.get(str(authored(material, _FRICTION_COMBINE)), "average")


def _summed(parts: Sequence[StatedMass]) -> StatedMass:
    """The masses of several colliders of one body; their common centre only when every one states its own."""
    if len(parts) == 1:
        return parts[0]
    masses = np.array([p.mass_kg for p in parts], dtype=np.float64)
    centres = [p.centre for p in parts if p.centre is not None]
    centre = np.average(centres, axis=0, weights=masses) if len(centres) == len(parts) and masses.sum() else None
    return replace(parts[0], mass_kg=float(masses.sum()), centre=centre, inertia=None)
