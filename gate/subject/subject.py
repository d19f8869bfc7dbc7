"""One reading of a composed stage for all rules, in metres and kilograms; each value is read once, on first use."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from gate.subject.body import Body, Collider, VisibleSurface, stacked
from gate.subject.frames import Frames
from gate.subject.joint import Joint
from gate.subject.read_joint import is_joint, read_joint
from gate.subject.read_shape import SHAPES, approximation_of, collider_points, is_convex, surface_of
from gate.subject.values import TIME, flag, number
from gate.subject.whole_surface import EdgeCounts, count_edges
from schemas.arrays import FloatArray
from schemas.diagnostics import Severity

METADATA = "SimReady_Metadata"
_SHOWN = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


@dataclass(frozen=True)
class Subject:
    """The composed stage of one asset, and the values that rules check; each is read once, on first use."""

    stage: Any
    main_file: Path

    @cached_property
    def prims(self) -> tuple[Any, ...]:
        """Every active, defined prim, those inside instances included, in stage order."""
        return tuple(Usd.PrimRange(self.stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))[1:]

    @cached_property
    def attributes(self) -> tuple[Any, ...]:
        """Every authored attribute of every prim outside instances."""
        return tuple(a for prim in self.prims if not prim.IsInstanceProxy() for a in prim.GetAuthoredAttributes())

    @property
    def package_folder(self) -> Path:
        """`<asset>` of `<asset>/<one folder>/<main file>`."""
        return self.main_file.resolve().parent.parent

    @cached_property
    def metadata(self) -> dict[str, Any]:
        """The SimReady metadata of the root layer; empty when there are none."""
        metadata = self.stage.GetRootLayer().customLayerData.get(METADATA)
        return dict(metadata) if isinstance(metadata, dict) else {}

    @cached_property
    def record(self) -> dict[str, Any] | None:
        """The AssetRecord that lies beside the package's USD folder, as plain JSON; None when there is none."""
        path = self.package_folder / "record.json"
        try:
            record = json.loads(path.read_text()) if path.is_file() else None
        except (OSError, ValueError):
            return None
        return record if isinstance(record, dict) and "asset_id" in record else None

    def record_value(self, *keys: str) -> Any:
        """The value of the record under nested keys; None when there is none."""
        value: Any = self.record
        for key in keys:
            value = value.get(key) if isinstance(value, dict) else None
        return value

    @cached_property
    def released(self) -> bool:
        """True iff the asset claims to be a SimReady package, so that the package's conventions bind it."""
        return bool(self.metadata) or self.record is not None

    @property
    def required_severity(self) -> Severity:
        """Severity of a violated package requirement: an error in a package, `info` in any other file."""
        return Severity.ERROR if self.released else Severity.INFO

    @property
    def suspect_severity(self) -> Severity:
        """Severity of a defect that may be intended outside packages: an error in a package, else a warning."""
        return Severity.ERROR if self.released else Severity.WARNING

    @cached_property
    def frames(self) -> Frames:
        """World transforms in metres."""
        return Frames.of(self.stage)

    @cached_property
    def kilograms_per_unit(self) -> float:
        """1 without a valid value, which the units rule reports."""
        try:
            value = float(self.stage.GetRootLayer().pseudoRoot.GetInfo("kilogramsPerUnit") or 1.0)
        except (TypeError, ValueError):
            return 1.0
        return value if np.isfinite(value) and value > 0.0 else 1.0

    @cached_property
    def root(self) -> Any:
        """The default prim, or the pseudo-root when there is none."""
        return self.stage.GetDefaultPrim() or self.stage.GetPseudoRoot()

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Prims with a rigid-body API, also disabled ones."""
        return tuple(self._body(prim) for prim in self._body_prims)

    @cached_property
    def active_bodies(self) -> tuple[Body, ...]:
        """Bodies that are enabled."""
        return tuple(body for body in self.bodies if body.enabled)

    @cached_property
    def colliders(self) -> tuple[Collider, ...]:
        """Every prim with a collision API, static ones included."""
        return tuple(self._collider(prim) for prim in self.prims if prim.HasAPI(UsdPhysics.CollisionAPI))

    @cached_property
    def surfaces(self) -> tuple[VisibleSurface, ...]:
        """Meshes and implicit shapes that a final render draws, prototypes of point instancers left out."""
        return tuple(surface_of(prim, self.frames) for prim in self.visible_prims)

    @cached_property
    def visible_prims(self) -> tuple[Any, ...]:
        """The prims of `surfaces`."""
        return tuple(prim for prim in self.prims if self._drawn(prim))

    @cached_property
    def meshes(self) -> tuple[Any, ...]:
        """All Mesh prims, colliders included."""
        return tuple(prim for prim in self.prims if prim.IsA(UsdGeom.Mesh))

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """Every joint."""
        return tuple(read_joint(prim, self.frames, self.body_of) for prim in self.prims if is_joint(prim))

    @cached_property
    def contact_materials(self) -> tuple[Any, ...]:
        """Prims with a physics-material API."""
        return tuple(prim for prim in self.prims if prim.HasAPI(UsdPhysics.MaterialAPI))

    @cached_property
    def materials(self) -> tuple[Any, ...]:
        """Prims of type Material."""
        return tuple(prim for prim in self.prims if prim.IsA(UsdShade.Material))

    @cached_property
    def shaders(self) -> tuple[Any, ...]:
        """Prims of type Shader."""
        return tuple(prim for prim in self.prims if prim.IsA(UsdShade.Shader))

    @cached_property
    def visible_points_W(self) -> FloatArray:
        """(n, 3) points of everything visible."""
        return stacked([s.points_W for s in self.surfaces])

    @cached_property
    def visible_edges(self) -> EdgeCounts | None:
        """Edge counts of all visible surfaces; None when there are none or too many triangles."""
        return count_edges(self.surfaces)

    def body_of(self, prim: Any) -> Body | None:
        """The body `prim` belongs to: itself or its nearest ancestor with a rigid-body API."""
        path = self._owner(prim)
        return next((body for body in self.bodies if body.path == path), None)

    @cached_property
    def _body_prims(self) -> tuple[Any, ...]:
        return tuple(prim for prim in self.prims if prim.HasAPI(UsdPhysics.RigidBodyAPI))

    @cached_property
    def _body_paths(self) -> frozenset[str]:
        return frozenset(str(prim.GetPath()) for prim in self._body_prims)

    def _owner(self, prim: Any) -> str | None:
        while prim and not prim.IsPseudoRoot():
            if str(prim.GetPath()) in self._body_paths:
                return str(prim.GetPath())
            prim = prim.GetParent()
        return None

    def _body(self, prim: Any) -> Body:
        path = str(prim.GetPath())
        X_WB, linear = self.frames.rigid(prim)
        applied = prim.HasAPI(UsdPhysics.MassAPI)
        mass = number(prim, "physics:mass") * self.kilograms_per_unit if applied else np.nan
        return Body(
            prim,
            flag(prim, "physics:rigidBodyEnabled", fallback=True),
            X_WB,
            linear,
            tuple(self._by_owner_colliders.get(path, ())),
            tuple(self._by_owner_surfaces.get(path, ())),
            mass if np.isfinite(mass) and mass > 0.0 else None,
        )

    @cached_property
    def _by_owner_colliders(self) -> dict[str | None, list[Collider]]:
        by_owner: dict[str | None, list[Collider]] = {}
        for collider in self.colliders:
            by_owner.setdefault(self._owner(collider.prim), []).append(collider)
        return by_owner

    @cached_property
    def _by_owner_surfaces(self) -> dict[str | None, list[VisibleSurface]]:
        by_owner: dict[str | None, list[VisibleSurface]] = {}
        for surface in self.surfaces:
            by_owner.setdefault(self._owner(surface.prim), []).append(surface)
        return by_owner

    def _collider(self, prim: Any) -> Collider:
        approximation = approximation_of(prim)
        return Collider(
            prim,
            flag(prim, "physics:collisionEnabled", fallback=True),
            collider_points(prim, self.frames),
            approximation,
            is_convex(prim, approximation),
        )

    def _drawn(self, prim: Any) -> bool:
        if prim.GetTypeName() not in SHAPES:
            return False
        imageable = UsdGeom.Imageable(prim)
        if imageable.ComputePurpose() not in _SHOWN or imageable.ComputeVisibility(TIME) == UsdGeom.Tokens.invisible:
            return False
        return not any(str(prim.GetPath()).startswith(f"{path}/") for path in self._instancers)

    @cached_property
    def _instancers(self) -> tuple[str, ...]:
        return tuple(str(prim.GetPath()) for prim in self.prims if prim.IsA(UsdGeom.PointInstancer))
