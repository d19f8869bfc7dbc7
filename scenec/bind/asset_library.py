"""Asset library: loads packages and inline primitives as bodies for scenes. No other module reads packages.

Articulated packages are loaded in a joint state, as if they were rigid in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from shapely.affinity import scale as stretch

from runtime_plan.package_files import changed_physics
from scenec.bind.anchors import drawn_surface, drawn_volume, recorded_surface, recorded_volume
from scenec.bind.asset_parts import AssetParts, asset_parts
from scenec.bind.joint_states import JointState
from scenec.bind.posed_asset import PosedAsset, swept_volumes
from scenec.bind.primitives import UPRIGHT, shape_of, stable_quats_wxyz, top_of
from scenec.bind.prisms import scaled, stance_of
from scenec.ir.problem import Body
from scenec.ir.single_assets import SingleAsset
from schemas.anchors import Anchor, ContainmentVolume, SupportSurface
from schemas.asset import AssetRecord
from schemas.diagnostics import InvalidInput, Severity, finding
from schemas.exercised import Exercised, exercised_ranges
from schemas.mechanism import Mechanism
from schemas.outcome import ItemOutcome
from schemas.physics import CollisionShape
from schemas.scene.geometry import ScenePlace, Stance
from schemas.scene.placing import Orientation
from schemas.scene.program import AuthoredPolygon, FixedAsset, Inline
from source.hint import did_you_mean
from usdio.reread.body import Linkage, reread_body, reread_linkage

MOST_SEEN = 5_000
Quat_wxyz = tuple[float, float, float, float]


@dataclass(frozen=True)
class Geometry:
    """Geometry of an asset, scale applied, in its asset frame: collision shapes, places, stable orientations."""

    asset_id: str
    shapes: tuple[CollisionShape, ...]
    surfaces: tuple[ScenePlace, ...]
    volumes: tuple[ScenePlace, ...]
    stable_quats_wxyz: tuple[Quat_wxyz, ...]
    roles: frozenset[str]
    mass_kg: float | None
    package: str | None
    inline: Inline | None = None
    doubts: tuple[str, ...] | None = None  # codes of the warnings of a package in review; None for any other
    posed: PosedAsset | None = None  # of an articulated asset
    density_kgm3: float | None = None
    exercised: Exercised | None = None  # None where nobody tried: primitives, and assets at another size
    parts: AssetParts = ()
    leaning_deg: Mapping[str, float] = field(default_factory=dict[str, float])  # places that lean in this state

    @cached_property
    def lean_deg(self) -> float:
        """How far the stable pose nearest to upright leans (degrees), 0 where no stable pose is known."""
        return min(
            (float(np.degrees(2.0 * np.arccos(min(abs(w), 1.0)))) for w, *_ in self.stable_quats_wxyz), default=0.0
        )

    @cached_property
    def beyond_feet_m(self) -> float:
        """How far the mass centre of an articulated asset is outside what it stands on in this state; 0 where it is
        inside, and of all others."""
        return max(self.posed.beyond_feet_m(), 0.0) if self.posed is not None and self.posed.moved else 0.0

    @property
    def joints(self) -> tuple[tuple[str, float], ...]:
        """(joint, position in m or rad) of all joints."""
        return () if self.posed is None else self.posed.positions


class AssetLibrary:
    """A folder of packages (`mana assets ingest --out`); with None only inline primitives are known."""

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self._geometries: dict[tuple[str, float, JointState], Geometry] = {}
        self._bodies: dict[tuple[str, float, JointState, Orientation, bool], Body] = {}
        self._records: dict[str, bytes] = {}
        self._checked: dict[str, AssetRecord] = {}
        self._linkages: dict[str, Linkage] = {}
        # By id of the asset object, for repeated requests.
        self._seen: dict[tuple[int, float, JointState], tuple[SingleAsset, Geometry]] = {}

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The ids of all packages."""
        if self.folder is None:
            return ()
        return tuple(sorted(record.parent.name for record in self.folder.glob("*/record.json")))

    def refresh(self) -> None:
        """Drops the list of packages, and all cached geometry where a package that was used has changed or is gone."""
        if any(self._record(asset_id) != record for asset_id, record in self._records.items()):
            for known in (
                self._geometries, self._bodies, self._records, self._checked, self._seen, self._linkages
            ):  # fmt: skip
                known.clear()
        self.__dict__.pop("names", None)

    def body(
        self,
        asset: SingleAsset,
        scale: float = 1.0,
        orientation: Orientation = "upright",
        sections: bool = False,
        state: JointState = (),
    ) -> Body:
        """The asset in each resting orientation, tapering shapes cut into `sections` (see scenec.bind.prisms).

        Raises InvalidInput as `geometry` does."""
        key = (asset.model_dump_json(), scale, state, orientation, sections)
        if key not in self._bodies:
            geometry = self.geometry(asset, scale, state)
            resting_orientations = [
                _stance(geometry, i, q, sections) for i, q in enumerate(_orientations(geometry, orientation))
            ]
            self._bodies[key] = Body(
                geometry.asset_id,
                tuple(resting_orientations),
                geometry.surfaces,
                geometry.volumes,
                geometry.mass_kg,
                geometry.package,
                scale,
                geometry.inline,
                joints=geometry.joints,
                parts=geometry.parts,
            )
        return self._bodies[key]

    def geometry(self, asset: SingleAsset, scale: float = 1.0, state: JointState = ()) -> Geometry:
        """Geometry of the asset in a joint state. Raises InvalidInput (`scene/unknown-asset`, `scene/unusable-asset`,
        `scene/scaled-joints`)."""
        seen = self._seen.get((id(asset), scale, state))
        if seen is not None and seen[0] is asset:
            return seen[1]
        key = (asset.model_dump_json(), scale, state)
        if key not in self._geometries:
            package = isinstance(asset, FixedAsset)
            self._geometries[key] = self._package(asset.id, scale, state) if package else _primitive(asset, scale)
        if len(self._seen) >= MOST_SEEN:
            self._seen.clear()
        self._seen[id(asset), scale, state] = asset, self._geometries[key]
        return self._geometries[key]

    def mechanism(self, asset: SingleAsset) -> Mechanism | None:
        """Links and joints of the asset, None where it has none. Raises InvalidInput as `geometry` does."""
        posed = self.geometry(asset).posed
        return None if posed is None else posed.linkage.mechanism

    def surface(
        self,
        asset: SingleAsset,
        scale: float,
        reference: str | AuthoredPolygon,
        name: str,
        state: JointState = (),
    ) -> ScenePlace | None:
        """The surface that `reference` names (`auto`: the main one) or draws (then called `name`); None when absent."""
        geometry = self.geometry(asset, scale, state)
        if isinstance(reference, AuthoredPolygon):
            return drawn_surface(name, reference, geometry.shapes)
        return next((s for s in geometry.surfaces if reference in ("auto", s.name)), None)

    def volume(
        self,
        asset: SingleAsset,
        scale: float,
        reference: str | AuthoredPolygon,
        name: str,
        state: JointState = (),
    ) -> ScenePlace | None:
        """The volume that `reference` names (`auto`: the main one) or draws (then called `name`); None when absent."""
        geometry = self.geometry(asset, scale, state)
        if isinstance(reference, AuthoredPolygon):
            return drawn_volume(name, reference, geometry.shapes)
        return next((v for v in geometry.volumes if reference in ("auto", v.name)), None)

    def _record(self, asset_id: str) -> bytes:
        """The bytes of a record, none where it cannot be read."""
        assert self.folder is not None, "only packages have records"
        try:
            return (self.folder / asset_id / "record.json").read_bytes()
        except OSError:
            return b""

    def _usable_record(self, asset_id: str) -> AssetRecord:
        """The record of a package whose physics are those that it was written of; read once. Raises InvalidInput."""
        if asset_id in self._checked:
            return self._checked[asset_id]
        if asset_id not in self.names:
            reason = "there is no asset library" if self.folder is None else "the library has none of that name"
            headline = f"no asset `{asset_id}`: {reason}{did_you_mean(asset_id, self.names)}"
            raise InvalidInput(finding("scene/unknown-asset", headline))
        assert self.folder is not None, "it holds the package"
        self._records[asset_id] = self._record(asset_id)
        try:
            record = AssetRecord.model_validate_json(self._records[asset_id])
        except ValueError:
            raise _unusable(asset_id, "its record.json is not the record of an asset") from None
        changed = changed_physics(self.folder / asset_id, record.hashes)
        if changed:
            reason = f"'{changed[0]}' is not the file that was tried in simulation: ingest the asset again"
            raise _unusable(asset_id, reason)
        self._checked[asset_id] = record
        return record

    def _package(self, asset_id: str, scale: float, state: JointState) -> Geometry:
        record = self._usable_record(asset_id)
        assert self.folder is not None, "it holds the package"
        folder = self.folder / asset_id
        posed = None
        try:
            if record.physics.links:
                posed = self._posed(asset_id, folder, record, state)
                rigid = posed.body
            else:
                rigid = reread_body(folder / "usd" / f"{asset_id}.usda")
        except InvalidInput as error:
            raise _unusable(asset_id, error.diagnostic.headline) from None
        if record.outcome is ItemOutcome.REJECTED:
            raise _unusable(asset_id, "it was rejected")
        if not rigid.shapes:
            raise _unusable(asset_id, "it has no collision shape")
        if posed is not None and scale != 1.0:
            headline = f"`{asset_id}` has joints, whose limits and links are not scaled: it is used at its own size"
            raise InvalidInput(finding("scene/scaled-joints", headline, value=scale, bound=1.0))
        shapes = tuple(scaled(shape, scale) for shape in rigid.shapes)
        anchors, leaning = _level_anchors(record, posed)
        poses = sorted((p.value for p in record.acceptance.stable_poses), key=lambda p: -p.probability)
        if posed is not None and posed.moved:
            poses = []  # those of the record are of the rest state
        return Geometry(
            asset_id,
            shapes,
            tuple(recorded_surface(a, shapes, scale) for a in anchors if isinstance(a, SupportSurface)),
            tuple(recorded_volume(a, shapes, scale) for a in anchors if isinstance(a, ContainmentVolume)),
            tuple(swing_and_yaw(p.quat_wxyz)[0] for p in poses),
            frozenset(role.value for role in record.semantics.roles if role.confidence > 0.0),
            record.physics.mass_kg.value * scale**3,
            asset_id,
            doubts=_doubts(record),
            posed=posed,
            density_kgm3=record.physics.density_kgm3.value,
            exercised=None if scale != 1.0 else exercised_ranges(record),
            parts=asset_parts(record, scale, posed is not None and posed.moved),
            leaning_deg=leaning,
        )

    def _posed(self, asset_id: str, folder: Path, record: AssetRecord, state: JointState) -> PosedAsset:
        if asset_id not in self._linkages:
            self._linkages[asset_id] = reread_linkage(folder / "usd" / f"{asset_id}.usda")
        return PosedAsset(asset_id, self._linkages[asset_id], state, swept_volumes(record.joint_uses))


def _level_anchors(record: AssetRecord, posed: PosedAsset | None) -> tuple[list[Anchor], dict[str, float]]:
    """The anchors of an asset in its joint state, and by how many degrees those lean that are not level there."""
    anchors: list[Anchor] = []
    leaning: dict[str, float] = {}
    for evidence in record.anchors:
        anchor = evidence.value if posed is None else posed.anchor(evidence.value)
        if isinstance(anchor, float | int):
            leaning[evidence.value.anchor_id] = anchor
        else:
            anchors.append(anchor)
    return anchors, leaning


def _doubts(record: AssetRecord) -> tuple[str, ...] | None:
    if record.outcome is not ItemOutcome.REVIEW:
        return None
    return tuple(dict.fromkeys(d.code for d in record.diagnostics if d.severity is Severity.WARNING))


def _primitive(asset: Inline, scale: float) -> Geometry:
    tops = tuple(_enlarged(top, scale) for top in top_of(asset))
    mass_kg = None if asset.mass_kg is None else asset.mass_kg * scale**3
    shapes = (scaled(shape_of(asset), scale),)
    return Geometry(asset.type, shapes, tops, (), stable_quats_wxyz(asset), frozenset(), mass_kg, None, asset)


def swing_and_yaw(quat_wxyz: Sequence[float]) -> tuple[Quat_wxyz, float]:
    """Swing-twist decomposition: a rotation about a horizontal axis, then the yaw (rad) about the vertical."""
    w, x, y, z = np.asarray(quat_wxyz, dtype=np.float64) / np.linalg.norm(quat_wxyz)
    half = np.arctan2(z, w) if np.hypot(w, z) > 1e-9 else 0.0
    c, s = np.cos(half), np.sin(half)  # the turn back about z is (c, 0, 0, -s), multiplied from the left
    swing = (c * w + s * z, c * x + s * y, c * y - s * x, c * z - s * w)
    a, b, d, e = (round(float(q), 12) + 0.0 for q in swing)
    return (a, b, d, e), float(2.0 * half)


def _orientations(geometry: Geometry, orientation: Orientation) -> tuple[Quat_wxyz, ...]:
    if orientation == "upright":
        return (UPRIGHT,)
    if orientation == "stable":
        return geometry.stable_quats_wxyz or (UPRIGHT,)
    return tuple(_unit(quat) for quat in orientation)


def _unit(quat_wxyz: Quat_wxyz) -> Quat_wxyz:
    w, x, y, z = (float(q) for q in np.asarray(quat_wxyz) / np.linalg.norm(quat_wxyz))
    return w, x, y, z


def _stance(geometry: Geometry, index: int, quat_wxyz: Quat_wxyz, sections: bool) -> Stance:
    return stance_of(geometry.shapes, quat_wxyz, "upright" if quat_wxyz == UPRIGHT else f"pose_{index}", sections)


def _enlarged(surface: ScenePlace, scale: float) -> ScenePlace:
    if scale == 1.0:
        return surface
    polygon = stretch(surface.polygon, scale, scale, origin=(0.0, 0.0))
    return ScenePlace(surface.name, polygon, surface.origin_P_m * scale)


def _unusable(asset_id: str, why: str) -> InvalidInput:
    return InvalidInput(finding("scene/unusable-asset", f"the package `{asset_id}` cannot be used: {why}"))
