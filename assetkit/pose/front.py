"""Front direction and heading symmetry of an upright object, from its parts and openings; asset frame, z up.

The front is the functional side: away from the hand that holds it (mug, pan, tool), where the spout pours, where one
sits down, where a case is open. It is unknown without evidence, and undefined where the object has a heading symmetry.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from assetkit.parts.proposals import join_meshes
from geom.features.cavities import Cavity
from geom.features.mirror_symmetry import mirror_plane_heading
from geom.features.regions import FaceGeometry
from geom.mesh.surface_distance import NearestOnSurface, sample_surface
from schemas.arrays import FloatArray, IntArray
from schemas.asset import Vec3, vec3
from schemas.evidence import Evidence, default, inferred, measured
from schemas.model import Mesh
from schemas.parts import Part

LabelledFaces = tuple[Evidence[str], IntArray]  # label of a part, and the mask of its triangles (m,)
FULL = 0  # symmetry of an object that looks the same in every heading
_FRONT_SAMPLES = 1500
_SAME = 0.01  # of the extent: mean distance of a turned surface from itself; scans are no better
_NOWHERE = 3.0  # times that for 95 % of the surface: a thin spout is little surface but distinguishes the headings
_FOLDS = (6, 5, 4, 3, 2)
_ROUGH_RAD = np.radians(15.0)  # Accuracy of a heading from parts: the mirror plane near it is used ...
_MIRRORED = 0.03  # ... where the surface is so well its own image (mean distance, of the extent).
_AXIS_RAD = np.radians(5.0)  # A mirror plane so close to an axis of the source is that axis: sources are built along
# them, and a turn by a few degrees would only change the box that their users know.
_BOX_LIKE = 0.9  # length of the mean of unit vectors of four times the headings of walls: 1 for a box, 0 for a cylinder
_OFF = 0.15  # of the larger half extent: a part nearer to the middle has no side
_BY_HANDLE, _BY_SPOUT, _BY_BACK, _BY_OPENING, _BY_DOOR = 0.9, 0.9, 0.9, 0.8, 0.8
_HANDHELD = (
    "mug",
    "cup",
    "pan",
    "pitcher",
    "teapot",
    "spoon",
    "fork",
    "knife",
    "cooking_utensil",
    "hammer",
    "screwdriver",
)
_SEATS = ("chair", "sofa", "bench")
_CASES = ("shelf", "cabinet", "refrigerator", "microwave", "oven", "dishwasher", "washing_machine")


@dataclass(frozen=True)
class Front:
    """`direction` (3,) level unit vector of the asset frame, unknown with confidence 0; `symmetry` the number of
    headings in which the object looks the same: 1 none, 0 all.
    """

    direction: Evidence[Vec3]
    symmetry: Evidence[int]


def front_of(
    meshes: Mapping[str, Mesh], category: Evidence[str], parts: Sequence[Evidence[Part]], cavities: Sequence[Cavity]
) -> Front:
    """The front of canonical `meshes` by id; its confidence is at most that of the category and of the cue."""
    shown = {mesh_id: mesh for mesh_id, mesh in meshes.items() if len(mesh.triangles)}
    surface = join_meshes(list(shown.values())) if shown else None
    if surface is None or surface.area.sum() <= 0.0:
        return Front(_unknown("no surface"), default(1, "no surface"))
    symmetry = heading_symmetry(surface)
    symmetry_evidence = measured(symmetry, "distance of the turned surface from itself", confidence=0.9)
    if symmetry != 1:
        return Front(_unknown("looks the same in other headings"), symmetry_evidence)
    masks = [
        (p.value.label, np.concatenate([p.value.mask(mesh_id, len(m.triangles)) for mesh_id, m in shown.items()]))
        for p in parts
    ]
    signs = _signs(surface, category.value, masks, cavities)
    if not signs:
        return Front(_unknown("nothing tells the front"), symmetry_evidence)
    directions = np.array([direction for direction, _, _ in signs])
    if (directions @ directions[0] < np.cos(2.0 * _ROUGH_RAD)).any():
        return Front(_unknown("contradicting: " + "; ".join(text for _, _, text in signs)), symmetry_evidence)
    sure = min(max(chance for _, chance, _ in signs), category.confidence)
    direction = _straightened(surface, directions[0])
    return Front(
        inferred(vec3(direction), "where it works", sure, inputs=tuple(t for _, _, t in signs)), symmetry_evidence
    )


def turn_to_front(front: Front) -> tuple[FloatArray, Front] | None:
    """The turn (3, 3) about z that brings a known front to +x, exact for quarter turns, and the front after it."""
    x, y, _ = front.direction.value
    if front.direction.confidence == 0.0 or x == 1.0:
        return None
    R = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])
    return R, replace(front, direction=front.direction.model_copy(update={"value": (1.0, 0.0, 0.0)}))


def heading_symmetry(surface: FaceGeometry) -> int:
    """In how many headings about the upright axis the surface looks the same: 0 for all, else 6, 5, 4, 3, 2 or 1."""
    points, _ = sample_surface(surface.points, surface.triangles, _FRONT_SAMPLES, 0)
    centre = _middle(surface)
    nearest = NearestOnSurface(surface.points - centre, surface.triangles)
    slack = _SAME * float(surface.extent.max())

    def same(angle: float) -> bool:
        c, s = np.cos(angle), np.sin(angle)
        turned = (points - centre) @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T
        off = np.linalg.norm(nearest(turned)[0] - turned, axis=1)
        return bool(off.mean() < slack and np.quantile(off, 0.95) < _NOWHERE * slack)

    if all(same(angle) for angle in (1.0, 2.3)):
        return FULL
    return next((n for n in _FOLDS if same(2.0 * np.pi / n)), 1)


def _signs(
    surface: FaceGeometry, category: str, parts: Sequence[LabelledFaces], cavities: Sequence[Cavity]
) -> list[tuple[FloatArray, float, str]]:
    """Level unit directions (3,) of the front, each with its confidence and its cue in words."""
    signs: list[tuple[FloatArray, float, str]] = []
    if category in _HANDHELD:
        signs += _by_part(surface, parts, "spout", 1.0, _BY_SPOUT)
        signs += _by_part(surface, parts, "handle", -1.0, _BY_HANDLE)
    if category in _SEATS:
        signs += _by_part(surface, parts, "back", -1.0, _BY_BACK)
    if category in _CASES:
        for label in ("door", "drawer", "knob"):
            signs += _by_side(surface, parts, label) or _by_part(surface, parts, label, 1.0, _BY_DOOR)
        level = [c for c in cavities if abs(c.direction[2]) < 0.1 and not c.through]
        if level:
            widest = max(level, key=lambda c: c.volume_m3)
            signs.append((_level(widest.direction), _BY_OPENING, "opening"))
    return signs


def _by_part(
    surface: FaceGeometry, parts: Sequence[LabelledFaces], label: str, sign: float, sure: float
) -> list[tuple[FloatArray, float, str]]:
    """One sign from the position of the parts of a label; none when they surround the object or lie in its middle."""
    labelled = [(evidence, faces) for evidence, faces in parts if evidence.value == label]
    if not labelled:
        return []
    faces = np.any([faces for _, faces in labelled], axis=0)
    place = np.average(surface.middle[faces], axis=0, weights=surface.area[faces])
    off = (place - _middle(surface)) * [1.0, 1.0, 0.0]
    if np.linalg.norm(off) < _OFF * 0.5 * float(surface.extent[:2].max()):
        return []
    confidence = sure * min(evidence.confidence for evidence, _ in labelled)
    return [(_level(sign * off), confidence, f"{label} on the {'front' if sign > 0.0 else 'back'}")]


def _by_side(surface: FaceGeometry, parts: Sequence[LabelledFaces], label: str) -> list[tuple[FloatArray, float, str]]:
    """One sign from the side of a box-like case that the parts of a label are nearest to; none without such sides.

    A door on one half of a case, or a knob in its corner, is not straight ahead of the middle.
    """
    labelled = [(evidence, faces) for evidence, faces in parts if evidence.value == label]
    heading = _side_heading(surface, 0.0)
    if not labelled or heading is None:
        return []
    faces = np.any([faces for _, faces in labelled], axis=0)
    place = np.average(surface.middle[faces], axis=0, weights=surface.area[faces])
    sides = [_on_axis(heading + np.pi / 2.0 * k, _AXIS_RAD) for k in range(4)]
    gaps = [float((surface.points @ side).max() - place @ side) for side in sides]
    near, next_near = np.argsort(gaps)[:2]
    if gaps[next_near] - gaps[near] < _OFF * 0.5 * float(surface.extent[:2].max()):
        return []
    confidence = _BY_DOOR * min(evidence.confidence for evidence, _ in labelled)
    return [(sides[near], confidence, f"{label} on the front")]


def _middle(surface: FaceGeometry) -> FloatArray:
    """Area centroid (3,) of the surface: on every axis and plane of symmetry, unlike the middle of the box."""
    return np.average(surface.middle, axis=0, weights=surface.area)


def _level(direction: FloatArray) -> FloatArray:
    flat = np.array([direction[0], direction[1], 0.0])
    return flat / np.linalg.norm(flat)


def _straightened(surface: FaceGeometry, direction: FloatArray) -> FloatArray:
    """The direction snapped to a wall of a box-like surface or to a mirror plane near it, then to an axis near."""
    heading = float(np.arctan2(direction[1], direction[0]))
    side = _side_heading(surface, heading)
    if side is not None and abs(heading - side) < _ROUGH_RAD:
        return _on_axis(side, _AXIS_RAD)
    mirror = mirror_plane_heading(surface.points, surface.triangles, _middle(surface), heading, 1.4 * _ROUGH_RAD)
    if mirror is None or mirror[1] > _MIRRORED * float(surface.extent.max()):
        return _on_axis(heading, _ROUGH_RAD)
    return _on_axis(mirror[0], _AXIS_RAD)


def _side_heading(surface: FaceGeometry, heading: float) -> float | None:
    """The heading of the side of a box-like surface nearest to a heading; None where its walls have no four headings.

    A door on one half of a case is not straight ahead of its middle, but its case looks where its walls do. Headings
    count modulo a quarter turn, by the level area that faces them.
    """
    level = surface.area * np.linalg.norm(surface.normal[:, :2], axis=1)
    quarters = np.exp(4j * np.arctan2(surface.normal[:, 1], surface.normal[:, 0]))
    resultant = complex((level * quarters).sum()) / max(float(level.sum()), 1e-300)
    if abs(resultant) < _BOX_LIKE:
        return None
    walls = float(np.angle(resultant)) / 4.0
    return walls + np.pi / 2.0 * round((heading - walls) / (np.pi / 2.0))


def _on_axis(heading: float, near_rad: float) -> FloatArray:
    """(3,) the axis next to the heading when it is so near, else the heading itself."""
    quarter = np.pi / 2.0 * round(heading / (np.pi / 2.0))
    if abs(heading - quarter) < near_rad:
        return np.rint([np.cos(quarter), np.sin(quarter), 0.0])
    return np.array([np.cos(heading), np.sin(heading), 0.0])


def _unknown(why: str) -> Evidence[Vec3]:
    return default((1.0, 0.0, 0.0), why)
