"""Articulated packages of known measures for scenes: a drawer unit, a microwave, a chest with a lid, a four-bar.

All stand on z = 0 with their front at +x and their joints shut at rest. Records hold the anchors and swept volumes that
the pipeline would find.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from geom.mass.inertia import combine
from jobs.cache import file_sha256
from schemas.anchors import AnchorPolygon
from schemas.appearance.material import Material
from schemas.articulation import JointUse, SweptPrism, SweptVolume
from schemas.evidence import declared, inferred
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismLink
from schemas.package import LinkBody
from schemas.physics import CollisionShape, MassProperties
from tests.support import package_samples as samples
from usdio.write.package import write_package

RECORD = Path(__file__).parents[2] / "data" / "record.json"
DENSITY_KGM3 = 400.0
X, Y, Z = np.eye(3)
MATERIALS = (Material("body", (0.62, 0.5, 0.38)), Material("moving", (0.3, 0.42, 0.55)))


@dataclass(frozen=True)
class Panel:
    """A box of a link: edges and centre in the asset frame at rest (m)."""

    link: str
    size_m: tuple[float, float, float]
    centre_m: tuple[float, float, float]

    @property
    def shape(self) -> CollisionShape:
        X_AS = np.eye(4)
        X_AS[:3, 3] = self.centre_m
        return CollisionShape("box", self.size_m, X_AS)

    @property
    def mass(self) -> MassProperties:
        mass_kg = DENSITY_KGM3 * math.prod(self.size_m)
        edges = np.array(self.size_m)
        return MassProperties(mass_kg, np.array(self.centre_m), mass_kg / 12.0 * np.diag((edges**2).sum() - edges**2))

    @property
    def outline(self) -> shapely.Polygon:
        (x, y, _), (u, v, _) = self.centre_m, self.size_m
        return shapely.box(x - u / 2, y - v / 2, x + u / 2, y + v / 2)

    @property
    def heights_m(self) -> tuple[float, float]:
        return self.centre_m[2] - self.size_m[2] / 2, self.centre_m[2] + self.size_m[2] / 2


# A drawer unit: 0.36 deep, 0.4 wide, 0.44 high, walls of 2 cm; two drawers that slide out along +x.
DRAWER_TRAVEL_M = 0.25
DRAWER_FLOORS_M = (0.03, 0.24)  # heights of what rests in drawer_1 and drawer_2
DRAWER_INSIDE_M = (0.28, 0.32, 0.1)  # depth, width, height


def drawer_panels() -> list[Panel]:
    panels = [Panel("case", (0.34, 0.02, 0.4), (-0.01, side * 0.19, 0.22)) for side in (-1, 1)] + [
        Panel("case", (0.36, 0.4, 0.02), (0.0, 0.0, 0.43)),
        Panel("case", (0.34, 0.4, 0.02), (-0.01, 0.0, 0.01)),
        Panel("case", (0.02, 0.36, 0.4), (-0.17, 0.0, 0.22)),
    ]
    for name, floor in zip(("drawer_1", "drawer_2"), DRAWER_FLOORS_M, strict=True):
        panels += [
            Panel(name, (0.3, 0.34, 0.008), (0.0, 0.0, floor - 0.004)),
            Panel(name, (0.01, 0.34, 0.1), (-0.145, 0.0, floor + 0.05)),
            Panel(name, (0.3, 0.01, 0.1), (0.0, -0.165, floor + 0.05)),
            Panel(name, (0.3, 0.01, 0.1), (0.0, 0.165, floor + 0.05)),
            Panel(name, (0.02, 0.39, 0.18), (0.171, 0.0, floor + 0.075)),
        ]
    return panels


def drawer_unit(library: Path) -> None:
    """`drawer_unit`: joints and links `drawer_1`, `drawer_2`; volumes `drawer_1/inside`, `drawer_2/inside`."""
    panels = drawer_panels()
    joints = [_slide(f"drawer_{i}", "case", f"drawer_{i}", DRAWER_TRAVEL_M) for i in (1, 2)]
    top = surface_of("surface_0", (0.0, 0.0, 0.44), (0.34, 0.38))
    insides = [
        _volume(f"drawer_{i}/inside", (0.0, 0.0, floor), DRAWER_INSIDE_M, f"drawer_{i}")
        for i, floor in zip((1, 2), DRAWER_FLOORS_M, strict=True)
    ]
    uses = [_use(joint.name, _slid(panels, joint), 0.0, DRAWER_TRAVEL_M) for joint in joints]
    mechanism = Mechanism((_link("case"), _link("drawer_1"), _link("drawer_2")), tuple(joints))
    package(library, "drawer_unit", panels, mechanism, [top, *insides], uses)


# A microwave: 0.36 deep, 0.48 wide, 0.28 high; the door hangs at y = +0.24 and opens towards +x.
DOOR_HINGE_M = np.array([0.18, 0.24, 0.0])
DOOR_LIMITS_RAD = (0.0, 1.8)


def microwave_panels() -> list[Panel]:
    return [
        Panel("body", (0.36, 0.48, 0.02), (0.0, 0.0, 0.01)),
        Panel("body", (0.36, 0.48, 0.02), (0.0, 0.0, 0.27)),
        Panel("body", (0.02, 0.48, 0.24), (-0.17, 0.0, 0.14)),
        Panel("body", (0.34, 0.02, 0.24), (0.01, 0.23, 0.14)),
        Panel("body", (0.34, 0.12, 0.24), (0.01, -0.18, 0.14)),
        Panel("door", (0.03, 0.48, 0.28), (0.195, 0.0, 0.14)),
        Panel("plate", (0.2, 0.2, 0.01), (0.0, 0.05, 0.03)),
    ]


def microwave(library: Path) -> None:
    """`microwave`: `door` turns about a vertical hinge, `plate` without end; a surface on the plate turns with it."""
    panels = microwave_panels()
    door = MechanismJoint("door", "revolute", "body", "door", DOOR_HINGE_M, Z, limits=DOOR_LIMITS_RAD)
    turn = MechanismJoint("turn", "continuous", "body", "plate", np.array([0.0, 0.05, 0.03]), Z)
    anchors = [
        surface_of("surface_0", (0.0, 0.0, 0.28), (0.36, 0.48)),
        surface_of("plate/top", (0.05, 0.05, 0.035), (0.1, 0.2), "plate", 0.22),
        _volume("body/inside", (0.01, 0.05, 0.02), (0.32, 0.32, 0.2)),
    ]
    uses = [_use("door", _swung(panels, door), *DOOR_LIMITS_RAD), _use("turn", None, 0.0, math.tau)]
    mechanism = Mechanism((_link("body"), _link("door", DOOR_HINGE_M), _link("plate", turn.anchor)), (door, turn))
    package(library, "microwave", panels, mechanism, anchors, uses)


# A chest: 0.3 x 0.4, 0.2 high, whose lid turns about its rear edge; a latch follows the lid.
LID_HINGE_M = np.array([-0.15, 0.0, 0.2])


def chest(library: Path, asset_id: str = "chest", latch_offset_m: float = 0.0) -> None:
    """`chest`: `lid` tilts back, `latch` follows it by 1 cm a radian; surface `lid/top` and volume `body/inside`.

    With `latch_offset_m` the coupling takes the latch elsewhere than it is drawn, also while the lid is shut.
    """
    panels = [
        Panel("body", (0.3, 0.4, 0.02), (0.0, 0.0, 0.01)),
        Panel("body", (0.02, 0.4, 0.18), (-0.14, 0.0, 0.11)),
        Panel("body", (0.02, 0.4, 0.18), (0.14, 0.0, 0.11)),
        Panel("body", (0.26, 0.02, 0.18), (0.0, -0.19, 0.11)),
        Panel("body", (0.26, 0.02, 0.18), (0.0, 0.19, 0.11)),
        Panel("lid", (0.3, 0.4, 0.02), (0.0, 0.0, 0.21)),
        Panel("latch", (0.01, 0.04, 0.03), (0.156, 0.0, 0.15)),
    ]
    lid = MechanismJoint("lid", "revolute", "body", "lid", LID_HINGE_M, -Y, limits=(0.0, 1.9))
    latch = MechanismJoint(
        "latch", "prismatic", "body", "latch", np.array([0.156, 0.0, 0.15]), -Z, limits=(0.0, 0.03),
        coupling=JointCoupling("lid", 0.01, latch_offset_m),
    )  # fmt: skip
    anchors = [
        surface_of("lid/top", (0.0, 0.0, 0.22), (0.3, 0.4), "lid"),
        _volume("body/inside", (0.0, 0.0, 0.02), (0.26, 0.36, 0.18)),
    ]
    mechanism = Mechanism((_link("body"), _link("lid", LID_HINGE_M), _link("latch", latch.anchor)), (lid, latch))
    package(library, asset_id, panels, mechanism, anchors, [])


def four_bar(library: Path) -> None:
    """`four_bar`: two arms on a base and a bar between them; `closing` closes the loop."""
    hinges = {side: np.array([x, 0.0, 0.06]) for side, x in (("left", -0.1), ("right", 0.1))}
    tops = {side: hinge + 0.1 * Z for side, hinge in hinges.items()}
    panels = [Panel("base", (0.3, 0.2, 0.05), (0.0, 0.0, 0.025)), Panel("bar", (0.2, 0.02, 0.02), (0.0, 0.03, 0.16))]
    panels += [Panel(side, (0.02, 0.02, 0.1), (float(hinge[0]), 0.0, 0.11)) for side, hinge in hinges.items()]
    joints = [
        MechanismJoint(side, "revolute", "base", side, hinge, Y, limits=(-1.0, 1.0)) for side, hinge in hinges.items()
    ]
    joints.append(MechanismJoint("bar", "revolute", "left", "bar", tops["left"], Y, limits=(-1.0, 1.0)))
    joints.append(MechanismJoint("closing", "continuous", "right", "bar", tops["right"], Y, closes_loop=True))
    links = [_link("base"), *(_link(side, hinges[side]) for side in hinges), _link("bar", tops["left"])]
    package(library, "four_bar", panels, Mechanism(tuple(links), tuple(joints)), [], [])


def articulated_library(folder: Path) -> Path:
    """All of them in one library."""
    drawer_unit(folder)
    microwave(folder)
    chest(folder)
    four_bar(folder)
    return folder


def package(
    library: Path,
    asset_id: str,
    panels: Sequence[Panel],
    mechanism: Mechanism,
    anchors: Sequence[Mapping[str, Any]],
    uses: Sequence[JointUse],
) -> None:
    """A package of boxes with these joints, and its record."""
    root = mechanism.root.name
    meshes = [
        samples.box_mesh(
            panel.size_m,
            f"{panel.link}_{i}",
            np.array(panel.centre_m) - [0.0, 0.0, panel.size_m[2] / 2],
            link=panel.link,
            material=int(panel.link != root),
        )
        for i, panel in enumerate(panels)
    ]
    content = samples.content(samples.model(meshes, MATERIALS), [panel.shape for panel in panels], asset_id=asset_id)
    bodies = tuple(
        LinkBody(
            link.name,
            tuple(i for i, panel in enumerate(panels) if panel.link == link.name),
            combine([panel.mass for panel in panels if panel.link == link.name]),
        )
        for link in mechanism.links
    )
    mass = combine([body.mass for body in bodies])
    content = replace(content, mechanism=mechanism, links=bodies, mass=mass, density_kgm3=DENSITY_KGM3)
    write_package(content, library / asset_id)
    files = sorted(file for file in (library / asset_id).rglob("*") if file.is_file())
    hashes = {file.relative_to(library / asset_id).as_posix(): file_sha256(file) for file in files}
    record = json.loads(RECORD.read_text()) | {"asset_id": asset_id, "outcome": "accepted", "hashes": hashes}
    measured = {"source": "measured", "method": "test", "confidence": 1.0}
    record["semantics"]["roles"] = [{"value": "fixture", **measured}]
    record["anchors"] = [{"value": anchor, **measured} for anchor in anchors]
    record["joint_uses"] = [use.model_dump(mode="json") for use in uses]
    record["acceptance"]["stable_poses"] = []
    physics = record["physics"]
    physics["mass_kg"] |= {"value": mass.mass_kg}
    keys = ("material", "density_kgm3", "mass_kg", "centre_of_mass_m", "inertia_kgm2")
    physics["links"] = [
        {key: physics[key] for key in keys}
        | {"name": link.name, "members": [], "origin_m": link.origin.tolist(), "collision_method": "by_hand"}
        | {"candidates": []}
        for link in mechanism.links
    ]
    (library / asset_id / "record.json").write_text(json.dumps(record))


def _link(name: str, origin: np.ndarray | None = None) -> MechanismLink:
    return MechanismLink(name, np.zeros(3) if origin is None else np.array(origin))


def _slide(name: str, parent: str, child: str, travel_m: float) -> MechanismJoint:
    return MechanismJoint(name, "prismatic", parent, child, np.zeros(3), X, limits=(0.0, travel_m))


def surface_of(
    anchor_id: str,
    at: tuple[float, float, float],
    size: tuple[float, float],
    link: str | None = None,
    clearance_m: float | None = None,
) -> dict[str, Any]:
    x, y = size[0] / 2, size[1] / 2
    polygon = {"outline_m": [[-x, -y], [x, -y], [x, y], [-x, y]]}
    surface = {"anchor_id": anchor_id, "kind": "surface", "link": link, "position_m": at, "polygon": polygon}
    return surface | {
        "normal": [0, 0, 1], "area_m2": size[0] * size[1], "clearance_m": clearance_m, "load_directions": [[0, 0, 1]]
    }  # fmt: skip


def _volume(
    anchor_id: str, at: tuple[float, float, float], size: tuple[float, float, float], link: str | None = None
) -> dict[str, Any]:
    x, y = size[0] / 2, size[1] / 2
    inside = {"outline_m": [[-x, -y], [x, -y], [x, y], [-x, y]]}
    volume = {"anchor_id": anchor_id, "kind": "volume", "link": link, "position_m": at, "opening": inside}
    volume |= {"direction": [0, 0, 1], "height_m": size[2], "volume_m3": math.prod(size), "passes_m": min(size[:2])}
    return volume | {"slices": [{"height_m": size[2] * (0.25 + 0.5 * i), "polygons": [inside]} for i in range(2)]}


def _use(joint: str, swept: SweptVolume | None, closed: float, opened: float) -> JointUse:
    return JointUse(
        joint=joint,
        group=inferred("unknown", "test", 0.0),
        task="open",
        closed=declared(closed, "test"),
        open=declared(opened, "test"),
        swept=swept,
    )


def _slid(panels: Sequence[Panel], joint: MechanismJoint) -> SweptVolume:
    """What a slide along +x sweeps: boxes that are longer by its travel."""
    assert joint.limits is not None
    travel = joint.limits[1]
    moved = [panel for panel in panels if panel.link == joint.child]
    areas = [
        shapely.box(p.outline.bounds[0], p.outline.bounds[1], p.outline.bounds[2] + travel, p.outline.bounds[3])
        for p in moved
    ]
    return _volume_of(areas, [panel.heights_m for panel in moved])


def _swung(panels: Sequence[Panel], joint: MechanismJoint, steps: int = 24) -> SweptVolume:
    """What a turn about a vertical axis sweeps: hulls of neighbouring poses, grown by the sagitta of their arcs."""
    assert joint.limits is not None
    angles = np.linspace(*joint.limits, steps + 1)
    hinge = joint.anchor[:2]
    areas, heights = [], []
    for panel in (panel for panel in panels if panel.link == joint.child):
        outline = shapely.get_coordinates(panel.outline)[:-1] - hinge
        radius = float(np.hypot(*outline.T).max())
        sagitta = radius * (1.0 - math.cos(0.5 * (angles[1] - angles[0])))
        turned = [outline @ np.array([[math.cos(q), math.sin(q)], [-math.sin(q), math.cos(q)]]) for q in angles]
        hulls = [shapely.MultiPoint(np.concatenate(pair) + hinge).convex_hull for pair in pairwise(turned)]
        areas.append(shapely.union_all([hull.buffer(sagitta) for hull in hulls]))
        heights.append(panel.heights_m)
    return _volume_of(areas, heights)


def _volume_of(areas: Sequence[Any], heights: Sequence[tuple[float, float]]) -> SweptVolume:
    prisms = []
    for area, (low, high) in zip(areas, heights, strict=True):
        ring = shapely.get_coordinates(area.exterior)[:-1].tolist()
        polygon = AnchorPolygon(outline_m=tuple((x, y) for x, y in ring))
        prisms.append(SweptPrism(polygon=polygon, low_m=low, high_m=high))
    volume = sum(area.area * (high - low) for area, (low, high) in zip(areas, heights, strict=True))
    return SweptVolume(prisms=tuple(prisms), volume_m3=volume)
