"""Small problems built by hand, for tests of the phases after reading and binding."""

from __future__ import annotations

import numpy as np
from shapely import box as rectangle

from scenec.ir.problem import Body, Placement, Problem, Thing
from schemas.scene.geometry import BACKGROUND, Domain, Prism, ScenePlace, SceneRelation, Stance
from schemas.scene.program import BoxAsset


def box_body(name: str, x: float, y: float, z: float) -> Body:
    """A box with its top as surface."""
    corners = np.array([[-x, -y], [x, -y], [x, y], [-x, y]]) / 2.0
    stance = Stance((1.0, 0.0, 0.0, 0.0), (Prism(corners, 0.0, z),), 0.0)
    top = ScenePlace("top", rectangle(-x / 2.0, -y / 2.0, x / 2.0, y / 2.0), np.array([0.0, 0.0, z]))
    return Body(name, (stance,), (top,), inline=BoxAsset(type="box", size_m=(x, y, z)))


def table_setting() -> tuple[Problem, dict[str, Placement]]:
    """A tray on a table turned by 30 degrees, a mug on the tray, a book left of the tray, and where they stand."""
    table, tray = box_body("table", 1.2, 0.8, 0.7), box_body("tray", 0.4, 0.3, 0.02)
    turn = np.radians(30.0)
    X_WB = np.eye(4)
    X_WB[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    X_WB[:3, 3] = 0.5, -0.2, 0.0
    top, inside = table.surfaces[0], tray.surfaces[0]
    things = (
        Thing("tray", tray, BACKGROUND, top, Domain(), ("layout", "nodes", "tray")),
        Thing("mug", box_body("mug", 0.08, 0.08, 0.1), "tray", inside, Domain(), ("layout", "nodes", "mug")),
        Thing("book", box_body("book", 0.2, 0.14, 0.03), BACKGROUND, top, Domain(), ("layout", "nodes", "book")),
    )
    relation = SceneRelation("before", ("book", "tray"), gap_m=0.02, path=("relations", 0), word="left_of")
    placements = {
        "tray": Placement(0.2, 0.0, np.pi / 2.0, 0),
        "mug": Placement(0.1, 0.05, 0.3, 0),
        "book": Placement(-0.2, 0.1, 0.0, 0),
    }
    return Problem("breakfast", table, X_WB, things, (relation,), 0.01), placements
