"""Strips and frames of mechanisms: every link is drawn where its joint puts it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from geom.mechanism_pose import link_motions
from render.camera import HERO_VIEW, camera
from render.joints import draw_motion, swept_frame
from render.motion_request import MotionRequest
from render.request import RenderRequest
from render.views import render_all
from schemas.appearance.material import Material
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismLink
from schemas.model import Model
from tests.support.drawn import RED, box, model

PX = 192
ROOT, DOOR, KNOB = "case", "door", "knob"
HINGE = MechanismJoint(
    "hinge", "revolute", ROOT, DOOR, np.array([0.2, 0.2, 0.0]), np.array([0.0, 0.0, 1.0]), limits=(0.0, np.pi / 2)
)
SLIDE = MechanismJoint(
    "slide",
    "prismatic",
    ROOT,
    KNOB,
    np.array([0.0, 0.0, 0.4]),
    np.array([0.0, 0.0, 1.0]),
    limits=(0.0, 0.4),
    coupling=JointCoupling("hinge", 0.2),
)


def mechanism(hinge: MechanismJoint = HINGE) -> Mechanism:
    links = tuple(MechanismLink(name, np.zeros(3)) for name in (ROOT, DOOR, KNOB))
    return Mechanism(links, (hinge, SLIDE))


def cabinet(hinge: MechanismJoint = HINGE) -> Model:
    """A grey case whose red front door is hinged at its left edge; a blue knob on top rises as the door opens."""
    meshes = (
        replace(box((0.4, 0.4, 0.4), (0.0, 0.0, 0.2)), id=ROOT, link=ROOT),
        replace(box((0.02, 0.4, 0.4), (0.21, 0.0, 0.2), 1), id=DOOR, link=DOOR),
        replace(box((0.1, 0.1, 0.1), (0.0, 0.0, 0.45), 2), id=KNOB, link=KNOB),
    )
    materials = (Material("grey"), Material("red", base_color=RED), Material("blue", base_color=(0.02, 0.02, 0.6)))
    return replace(model(*meshes, materials=materials), mechanism=mechanism(hinge))


def centre(picture: np.ndarray, channel: int) -> np.ndarray:
    """(2,) mean pixel (x, y) of what is red (0) or blue (2)."""
    others = picture.sum(axis=2) - picture[..., channel]
    rows, columns = np.nonzero(picture[..., channel] > 1.2 * others)
    return np.array([columns.mean(), rows.mean()])


def frames(content: Model, folder: Path, *openings_rad: float) -> list[np.ndarray]:
    assert content.mechanism is not None
    poses = [link_motions(content.mechanism, {"hinge": q}) for q in openings_rad]
    request = MotionRequest(content, {name: np.stack([p[name] for p in poses]) for name in poses[0]}, str(folder), PX)
    return [np.asarray(Image.open(path)).astype(int) for path in draw_motion(request)]


def test_links_are_drawn_where_their_joints_put_them(tmp_path: Path):
    content, openings = cabinet(), (0.0, np.pi / 2)
    motions = [link_motions(mechanism(), {"hinge": q}) for q in openings]
    frame = swept_frame(content, motions)
    closed, wide = frames(content, tmp_path, *openings)
    # Turned by +90 degrees about its left edge, which the z axis passes through, the door points away from the case.
    expected_m = {0: ((0.21, 0.0, 0.2), (0.4, 0.21, 0.2)), 2: ((0.0, 0.0, 0.45), (0.0, 0.0, 0.45 + 0.1 * np.pi))}
    for channel, places_m in expected_m.items():
        for picture, place_m in zip((closed, wide), places_m, strict=True):
            pixel = camera(HERO_VIEW, frame.extent).project(frame.from_asset(np.array([place_m])), PX)[0]
            assert np.abs(centre(picture, channel) - pixel).max() < 5.0, (channel, place_m)


def test_a_door_that_opens_the_other_way_looks_different(tmp_path: Path):
    inwards = replace(HINGE, axis=-HINGE.axis)
    assert swept_frame(cabinet(), [link_motions(mechanism(), {"hinge": 1.0})]).centre_m[0] > 0.05
    wrong = swept_frame(cabinet(inwards), [link_motions(mechanism(inwards), {"hinge": 1.0})])
    assert wrong.centre_m[0] < 0.02


def test_all_positions_are_inside_one_picture_and_equal_positions_give_equal_pixels(tmp_path: Path):
    pictures = frames(cabinet(), tmp_path, 0.0, 0.8, np.pi / 2, 0.0)
    assert np.array_equal(pictures[0], pictures[3])
    for picture in pictures:
        border = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])
        assert np.ptp(border) < 20, "the object is cut off"


def test_motion_that_the_hero_view_hides_is_drawn_from_another_corner(tmp_path: Path):
    """The same cabinet with its door at the back."""
    front = cabinet()
    turn = np.diag([-1.0, -1.0, 1.0])
    meshes = tuple(replace(m, points=m.points @ turn, normals=None) for m in front.meshes)
    hinge = replace(HINGE, anchor=turn @ HINGE.anchor)
    turned = replace(front, meshes=meshes, mechanism=mechanism(hinge))
    ahead, behind = frames(front, tmp_path / "a", 0.0, 1.0), frames(turned, tmp_path / "b", 0.0, 1.0)
    for one, other in zip(ahead, behind, strict=True):
        assert np.abs(centre(one, 0) - centre(other, 0)).max() < 2.0


def test_only_a_mechanism_has_a_strip_of_three(tmp_path: Path):
    content = cabinet()
    paths = render_all(RenderRequest(content, (), str(tmp_path / "moving"), 128, joints=True))
    strip = Image.open(paths["joints"])
    assert strip.size == (384, 128)
    thirds = [np.asarray(strip.crop((k * 128, 0, (k + 1) * 128, 128))).astype(int) for k in range(3)]
    heights = [centre(third, 2)[1] for third in thirds]
    assert heights[0] - 4.0 > heights[1] > heights[2] + 4.0, "the knob that follows the door rises"
    rigid = render_all(RenderRequest(replace(content, mechanism=None), (), str(tmp_path / "rigid"), 128, joints=True))
    assert set(paths) - set(rigid) == {"joints"}
    for name, path in rigid.items():
        assert path.read_bytes() == paths[name].read_bytes()
