"""Anchors of links: insides of drawers and behind doors, tops, and what other links leave no room for; then tried."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from assetkit.articulation.link_anchor_trials import verify_link_anchors
from assetkit.articulation.link_anchors import cavities_of_links, propose_link_anchors
from geom.pose import pose
from schemas.anchors import Anchor, ContainmentVolume
from schemas.articulation import JointUse
from schemas.evidence import Evidence
from schemas.physics import CollisionShape
from sim.bullet.simulator import BulletSimulator
from tests.support.mechanism.drawn_mechanisms import DrawnMechanism, drawer, hinged_door

WIDTH, DEPTH, HEIGHT = 0.5, 0.4, 0.2
BOARD = 0.03 * WIDTH
DRAWER = drawer(WIDTH, DEPTH, HEIGHT, handle=False, travel=0.8)
CABINET = hinged_door(0.5, 0.4, 0.6, handle=False, turn=1.8, left=True)


def item(drawn: DrawnMechanism) -> ArticulatedObject:
    return ArticulatedObject(drawn.mechanism, drawn.links)


@cache
def read(kind: str) -> tuple[DrawnMechanism, tuple[JointUse, ...], tuple[Anchor, ...]]:
    """A mechanism with its uses and anchors; openings take seconds, so they are looked for once."""
    return read_anew({"drawer": DRAWER, "cabinet": CABINET}[kind])


def read_anew(drawn: DrawnMechanism) -> tuple[DrawnMechanism, tuple[JointUse, ...], tuple[Anchor, ...]]:
    uses = joint_uses(item(drawn))
    return drawn, uses, propose_link_anchors(item(drawn), uses, cavities_of_links(drawn.links))


def by_id(anchors: tuple[Anchor, ...]) -> dict[str, Anchor]:
    assert all(a.anchor_id.startswith(f"{a.link}/") for a in anchors)
    return {a.anchor_id: a for a in anchors}


def proposed(kind: str) -> dict[str, Anchor]:
    return by_id(read(kind)[2])


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> CollisionShape:
    a, b = np.array(low), np.array(high)
    x, y, z = (b - a).tolist()
    return CollisionShape("box", (x, y, z), pose(None, 0.5 * (a + b)))


def case_shapes(width: float, depth: float, height: float, board: float) -> list[CollisionShape]:
    x, y = 0.5 * width, 0.5 * depth
    return [
        block((-x, -y, 0.0), (x, y, board)),
        block((-x, -y, height - board), (x, y, height)),
        block((-x, y - board, 0.0), (x, y, height)),
        block((-x, -y, 0.0), (-x + board, y, height)),
        block((x - board, -y, 0.0), (x, y, height)),
    ]


def tray_shapes(low: tuple[float, float, float], high: tuple[float, float, float], wall: float) -> list[CollisionShape]:
    (a, b, c), (x, y, z) = low, high
    return [
        block(low, (x, y, c + wall)),
        block(low, (a + wall, y, z)),
        block((x - wall, b, c), high),
        block(low, (x, b + wall, z)),
        block((a, y - wall, c), high),
    ]


DRAWER_BOX = (
    (-0.5 * WIDTH + 1.2 * BOARD, -0.5 * DEPTH, 1.2 * BOARD),
    (0.5 * WIDTH - 1.2 * BOARD, 0.5 * DEPTH - 1.5 * BOARD, HEIGHT - 1.5 * BOARD),
)
DRAWER_SHAPES = {
    "body": case_shapes(WIDTH, DEPTH, HEIGHT, BOARD),
    "moved": tray_shapes(*DRAWER_BOX, 0.5 * BOARD),
}


def test_the_inside_of_a_shut_drawer_is_that_of_its_tray() -> None:
    inside = proposed("drawer")["moved/inside"]
    assert isinstance(inside, ContainmentVolume)
    low, high = np.array(DRAWER_BOX)
    wall = 0.5 * BOARD
    edges = high - low - [2 * wall, 2 * wall, wall]
    assert inside.volume_m3 == pytest.approx(float(np.prod(edges)), rel=0.03)
    assert inside.direction == (0.0, 0.0, 1.0)
    assert inside.link == "moved"


def test_the_room_that_a_shut_drawer_takes_is_no_anchor_of_the_body() -> None:
    ids = set(proposed("drawer"))
    assert "body/surface_0" in ids, "the top"
    assert {i for i in ids if i.startswith("body/")} == {"body/surface_0"}


def test_behind_a_door_lies_a_compartment_that_opens_to_the_door() -> None:
    anchors = proposed("cabinet")
    inside = anchors["body/inside"]
    assert isinstance(inside, ContainmentVolume)
    board = 0.03 * 0.5
    edges = [0.5 - 2 * board, 0.4 - board, 0.6 - 2 * board]
    assert inside.volume_m3 == pytest.approx(float(np.prod(edges)), rel=0.03)
    assert inside.direction == (0.0, -1.0, 0.0)
    floor = [a for a in anchors.values() if a.kind == "surface" and a.position_m[2] == pytest.approx(board, abs=1e-3)]
    assert [a.link for a in floor] == ["body"]


def test_without_a_door_an_open_front_is_no_containment() -> None:
    """The same case, and a drawer-like block far in front of it."""
    far = replace(
        CABINET.links[1], solid=replace(CABINET.links[1].solid, points=CABINET.links[1].solid.points - [0, 2, 0])
    )
    joint = replace(CABINET.joint, anchor=CABINET.joint.anchor - [0, 2, 0])
    moved = DrawnMechanism("", replace(CABINET.mechanism, joints=(joint,)), (CABINET.links[0], far))
    assert "body/inside" not in by_id(read_anew(moved)[2])


def verified(kind: str, shapes: dict[str, list[CollisionShape]]) -> dict[str, Evidence[Anchor]]:
    drawn, uses, anchors = read(kind)
    with BulletSimulator() as simulator:
        tried = verify_link_anchors(anchors, shapes, drawn.mechanism, uses, simulator)
    return {e.value.anchor_id: e for e in tried.anchors}


def test_a_drawer_is_verified_pulled_out_and_kept_at_rest() -> None:
    anchors = verified("drawer", DRAWER_SHAPES)
    inside = anchors["moved/inside"]
    assert inside.method.endswith("with joint at 0.32 m")
    assert inside.value == proposed("drawer")["moved/inside"], "given at rest, although tried pulled out"
    assert anchors["body/surface_0"].method.endswith(BulletSimulator().name), "at rest"


def test_a_drawer_whose_colliders_fill_it_is_refuted() -> None:
    filled = {**DRAWER_SHAPES, "moved": [block(*DRAWER_BOX)]}
    assert "moved/inside" not in verified("drawer", filled)


def test_what_lies_behind_a_door_is_verified() -> None:
    board = 0.03 * 0.5
    shapes = {
        "body": case_shapes(0.5, 0.4, 0.6, board),
        "moved": [block((-0.25, -0.22, 0.0), (0.25, -0.2, 0.6))],
    }
    anchors = verified("cabinet", shapes)
    assert {"body/inside", "body/surface_0"} <= set(anchors)
