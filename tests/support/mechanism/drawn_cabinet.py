"""A drawn articulated package of boxes: a cabinet that is open in front, with a drawer below and a door above.

The front is +x. The drawer slides out along +x by up to 0.3 m; the door turns outwards about its edge at y = -0.2 m by
up to 1.8 rad. Colliders are the boxes that are seen; masses are those of the boxes at 500 kg/m3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from geom.mass.inertia import combine, moved, of_box
from geom.pose import pose
from schemas.anchors import AnchorPolygon, ContainmentVolume, VolumeSlice
from schemas.articulation import JointContact
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from schemas.package import LinkBody, PackageContent
from schemas.physics import MassProperties
from tests.support.package_samples import box_mesh, content, hull_shape, model

DENSITY_KGM3 = 500.0
Box = tuple[tuple[float, float, float], tuple[float, float, float]]  # lower and upper corner, m

CABINET: dict[str, Box] = {
    "floor": ((-0.2, -0.2, 0.0), (0.2, 0.2, 0.02)),
    "back": ((-0.2, -0.2, 0.02), (-0.18, 0.2, 0.3)),
    "left": ((-0.18, -0.2, 0.02), (0.2, -0.18, 0.3)),
    "right": ((-0.18, 0.18, 0.02), (0.2, 0.2, 0.3)),
    "top": ((-0.18, -0.18, 0.28), (0.2, 0.18, 0.3)),
}
DRAWER: dict[str, Box] = {
    "bottom": ((-0.17, -0.176, 0.03), (0.17, 0.176, 0.04)),
    "rear": ((-0.17, -0.176, 0.04), (-0.16, 0.176, 0.13)),
    "front": ((0.16, -0.176, 0.04), (0.17, 0.176, 0.13)),
    "side_a": ((-0.16, -0.176, 0.04), (0.16, -0.166, 0.13)),
    "side_b": ((-0.16, 0.166, 0.04), (0.16, 0.176, 0.13)),
    "handle": ((0.17, -0.05, 0.08), (0.2, 0.05, 0.1)),
}
DOOR: dict[str, Box] = {"panel": ((0.201, -0.2, 0.16), (0.221, 0.19, 0.29))}
SLIDE = MechanismJoint(
    "slide",
    "prismatic",
    "cabinet",
    "drawer",
    np.array([0.0, 0.0, 0.03]),
    np.array([1.0, 0.0, 0.0]),
    limits=(0.0, 0.3),
    damping=1.0,
    source_name="slide",
)
HINGE = MechanismJoint(
    "hinge",
    "revolute",
    "cabinet",
    "door",
    np.array([0.221, -0.2, 0.16]),
    np.array([0.0, 0.0, -1.0]),
    limits=(0.0, 1.8),
    damping=0.05,
    source_name="hinge",
)
HANDLE = JointContact(
    kind="handle",
    link="drawer",
    position_m=(0.2, 0.0, 0.09),
    normal=(1.0, 0.0, 0.0),
    low_m=(0.17, -0.05, 0.08),
    high_m=(0.2, 0.05, 0.1),
    pull=(1.0, 0.0, 0.0),
)


def _inside() -> ContainmentVolume:
    x, y = 0.16, 0.166
    polygon = AnchorPolygon(outline_m=((-x, -y), (x, -y), (x, y), (-x, y)))
    return ContainmentVolume(
        anchor_id="drawer/inside",
        link="drawer",
        position_m=(0.0, 0.0, 0.04),
        opening=polygon,
        direction=(0.0, 0.0, 1.0),
        height_m=0.09,
        volume_m3=4.0 * x * y * 0.09,
        passes_m=0.2,
        slices=(VolumeSlice(height_m=0.045, polygons=(polygon,)),),
    )


INSIDE = _inside()


@dataclass(frozen=True)
class DrawnCabinet:
    """Boxes of each link, those of them that do not collide, the joints, and masses that replace the true ones."""

    boxes: Mapping[str, Mapping[str, Box]] = field(
        default_factory=lambda: {"cabinet": CABINET, "drawer": DRAWER, "door": DOOR}
    )
    without_collider: frozenset[str] = frozenset()
    joints: tuple[MechanismJoint, ...] = (SLIDE, HINGE)
    inertia_factor: Mapping[str, float] = field(default_factory=dict[str, float])

    def with_box(self, link: str, name: str, box: Box) -> DrawnCabinet:
        """The cabinet with one more box, or another one, in a link."""
        return replace(self, boxes={**self.boxes, link: {**self.boxes[link], name: box}})

    def with_joint(self, name: str, **changes: object) -> DrawnCabinet:
        """The cabinet with another joint of that name."""
        return replace(self, joints=tuple(replace(j, **changes) if j.name == name else j for j in self.joints))

    @property
    def mechanism(self) -> Mechanism:
        """Links and joints in the asset frame at rest."""
        origins = {joint.child: joint.anchor for joint in self.joints}
        return Mechanism(tuple(MechanismLink(n, origins.get(n, np.zeros(3))) for n in self.boxes), self.joints)

    def content(self) -> PackageContent:
        """The package to write."""
        meshes, shapes, bodies = [], [], []
        for link, boxes in self.boxes.items():
            first, masses = len(shapes), list[MassProperties]()
            for name, (low, high) in boxes.items():
                size = np.subtract(high, low)
                middle = np.add(high, low) / 2.0
                mesh = box_mesh(tuple(size), f"{link}_{name}", middle - [0.0, 0.0, size[2] / 2.0], link=link)
                meshes.append(mesh)
                masses.append(moved(of_box(tuple(size), DENSITY_KGM3), pose(None, middle)))
                if name not in self.without_collider:
                    shapes.append(hull_shape(mesh))
            mass = combine(masses)
            factor = self.inertia_factor.get(link, 1.0)
            mass = replace(mass, inertia_kgm2=mass.inertia_kgm2 * factor)
            bodies.append(LinkBody(link, tuple(range(first, len(shapes))), mass))
        plain = content(model(meshes), tuple(shapes))
        return replace(plain, mechanism=self.mechanism, links=tuple(bodies))
