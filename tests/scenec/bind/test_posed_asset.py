"""An asset at a joint state: its shapes are where MuJoCo has them, its anchors move along, its sweeps are covered."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
import shapely

from geom.pose import pose
from scenec.bind.asset_library import AssetLibrary
from scenec.bind.joint_states import JointState, joint_state
from scenec.bind.posed_asset import PosedAsset, beyond_feet_m
from scenec.bind.swept_space import swept_space
from schemas.anchors import AnchorPolygon, SupportSurface
from schemas.articulation import SweptPrism, SweptVolume
from schemas.diagnostics import InvalidInput
from schemas.mechanism import JointCoupling, Mechanism, MechanismJoint, MechanismLink
from schemas.physics import CollisionShape
from schemas.scene.program import FixedAsset
from tests.support.scene.articulated import (
    DOOR_LIMITS_RAD,
    DRAWER_TRAVEL_M,
    articulated_library,
    chest,
    surface_of,
)
from usdio.reread.body import Linkage

STATES = 20
MOST_OFF_M = 1e-4


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    return AssetLibrary(articulated_library(tmp_path_factory.mktemp("library")))


def asset(name: str) -> FixedAsset:
    return FixedAsset(type="fixed", id=name)


def random_state(mechanism: Mechanism, rng: np.random.Generator) -> dict[str, float]:
    free = [joint for joint in mechanism.joints if joint.coupling is None and not joint.closes_loop]
    return {joint.name: float(rng.uniform(*(joint.limits or (-3.0, 3.0)))) for joint in free}


def mujoco_corners(linkage: Linkage, positions: dict[str, float]) -> np.ndarray:
    """Corners of all boxes of the links, in the order of the links, as MuJoCo places them."""
    joints = {joint.child: joint for joint in linkage.mechanism.joints if not joint.closes_loop}
    origins = {link.name: link.origin for link in linkage.mechanism.links}

    def body(name: str) -> str:
        joint = joints.get(name)
        at = origins[name] - (origins[joint.parent] if joint else np.zeros(3))
        geoms = "".join(
            f'<geom type="box" pos="{_text(s.X_AS[:3, 3])}" size="{_text(np.array(s.size_m) / 2)}"/>'
            for link in linkage.links
            if link.name == name
            for s in link.shapes
        )
        inner = "".join(body(child) for child, one in joints.items() if one.parent == name)
        return f'<body name="{name}" pos="{_text(at)}">{_joint(joint, origins[name])}{geoms}{inner}</body>'

    world = body(linkage.mechanism.root.name)
    model = mujoco.MjModel.from_xml_string(f'<mujoco><compiler angle="radian"/><worldbody>{world}</worldbody></mujoco>')
    data = mujoco.MjData(model)
    for name, joint in ((j.name, j) for j in joints.values()):
        followed = joint.coupling
        at = positions[name] if followed is None else followed.multiplier * positions[followed.joint] + followed.offset
        data.joint(name).qpos[0] = at - joint.rest
    mujoco.mj_forward(model, data)
    corners = []
    for link in linkage.links:
        start = int(model.body(link.name).geomadr[0])
        for k in range(start, start + len(link.shapes)):
            X = pose(data.geom_xmat[k].reshape(3, 3), data.geom_xpos[k])
            corners.append(_corners(CollisionShape("box", tuple(2.0 * model.geom_size[k]), X)))
    return np.concatenate(corners)


def _joint(joint: MechanismJoint | None, origin: np.ndarray) -> str:
    if joint is None:
        return ""
    kind = "slide" if joint.kind == "prismatic" else "hinge"
    at, axis = _text(joint.anchor - origin), _text(joint.axis)
    return f'<joint name="{joint.name}" type="{kind}" pos="{at}" axis="{axis}"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'  # noqa: E501


def _text(values: np.ndarray) -> str:
    return " ".join(repr(float(v)) for v in values)


def _corners(shape: CollisionShape) -> np.ndarray:
    signs = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return signs * shape.size_m @ shape.X_AS[:3, :3].T + shape.X_AS[:3, 3]


@pytest.mark.parametrize("name", ["drawer_unit", "microwave", "chest"])
def test_shapes_are_where_mujoco_has_them(library: AssetLibrary, name: str):
    rng = np.random.default_rng(7)
    mechanism = library.mechanism(asset(name))
    assert mechanism is not None
    for _ in range(STATES):
        written = random_state(mechanism, rng)
        state, findings = joint_state(name, mechanism, written)
        assert not findings
        geometry = library.geometry(asset(name), state=state)
        assert geometry.posed is not None
        corners = np.concatenate([_corners(shape) for shape in geometry.shapes])
        off = np.linalg.norm(corners - mujoco_corners(geometry.posed.linkage, written), axis=1)
        assert off.max() < MOST_OFF_M
        named = dict(geometry.joints)
        assert all(named[joint] == pytest.approx(position) for joint, position in written.items())


def test_at_rest_nothing_is_moved(library: AssetLibrary):
    rest = library.geometry(asset("drawer_unit"))
    shut = library.geometry(asset("drawer_unit"), state=(("drawer_1", 0.0),))
    for one, other in zip(rest.shapes, shut.shapes, strict=True):
        assert np.array_equal(one.X_AS, other.X_AS)
    assert rest.joints == shut.joints == (("drawer_1", 0.0), ("drawer_2", 0.0))


def test_a_place_moves_with_its_link_only(library: AssetLibrary):
    rest = {place.name: place for place in library.geometry(asset("drawer_unit")).volumes}
    opened = {place.name: place for place in library.geometry(asset("drawer_unit"), state=(("drawer_1", 0.2),)).volumes}
    moved = {name: opened[name].origin_P_m - rest[name].origin_P_m for name in rest}
    assert np.allclose(moved["drawer_1/inside"], [0.2, 0.0, 0.0])
    assert np.allclose(moved["drawer_2/inside"], 0.0)
    assert {place.link for place in opened.values()} == {"drawer_1", "drawer_2"}


def test_a_turned_place_keeps_the_axes_of_its_owner(library: AssetLibrary):
    """The surface on the plate reaches from its axis (0, 0.05) 0.1 m along +x; a quarter turn takes it to +y."""

    def area(state: JointState) -> shapely.Polygon:
        place = next(p for p in library.geometry(asset("microwave"), state=state).surfaces if p.name == "plate/top")
        x, y = place.origin_P_m[:2]
        return shapely.affinity.translate(place.polygon, x, y)

    assert area(()).symmetric_difference(shapely.box(0.0, -0.05, 0.1, 0.15)).area < 1e-9
    assert area((("turn", math.pi / 2),)).symmetric_difference(shapely.box(-0.1, 0.05, 0.1, 0.15)).area < 1e-9
    place = next(
        p for p in library.geometry(asset("microwave"), state=(("turn", 0.7),)).surfaces if p.name == "plate/top"
    )
    low_x, low_y, high_x, high_y = place.polygon.bounds
    assert np.allclose([low_x + high_x, low_y + high_y], 0.0)  # its origin is the middle of its box


def test_a_place_that_leans_is_none(library: AssetLibrary):
    assert [p.name for p in library.geometry(asset("chest")).surfaces] == ["lid/top"]
    opened = library.geometry(asset("chest"), state=(("lid", 1.0),))
    assert opened.surfaces == ()
    assert opened.leaning_deg == {"lid/top": pytest.approx(math.degrees(1.0))}
    assert [p.name for p in opened.volumes] == ["body/inside"]


def test_away_from_rest_the_free_height_is_what_the_collision_shapes_leave(library: AssetLibrary):
    shut, opened = (library.geometry(asset("microwave"), state=s) for s in ((), (("turn", 0.1),)))
    height = {g.joints: next(p for p in g.surfaces if p.name == "plate/top") for g in (shut, opened)}
    recorded, from_shapes = height[shut.joints], height[opened.joints]
    assert recorded.height_m == pytest.approx(0.22, abs=5e-3)
    lowest = min(prism.low_m for prism in from_shapes.above if prism.low_m > 0.05)
    assert from_shapes.height_m == np.inf
    assert lowest == pytest.approx(0.26 - 0.035, abs=5e-3)  # the ceiling, as the collision shapes have it


@pytest.mark.parametrize(
    ("name", "joint", "limits"),
    [("microwave", "door", DOOR_LIMITS_RAD), ("drawer_unit", "drawer_2", (0.0, DRAWER_TRAVEL_M))],
)
def test_a_dense_sweep_lies_in_the_space_kept_clear(
    library: AssetLibrary, name: str, joint: str, limits: tuple[float, float]
):
    posed = library.geometry(asset(name)).posed
    assert posed is not None
    links, layers = swept_space(posed, joint)
    assert links == (joint,)
    shapes = next(link.shapes for link in posed.linkage.links if link.name == joint)
    origin = next(link.origin for link in posed.linkage.mechanism.links if link.name == joint)
    assert len(shapes) == (1 if joint == "door" else 5)
    for position in np.linspace(*limits, 60):
        X_AL = replace(posed, state=((joint, float(position)),)).motions[joint] @ pose(None, origin)
        for shape in shapes:
            corners = _corners(shape) @ X_AL[:3, :3].T + X_AL[:3, 3]
            outline = shapely.MultiPoint(corners[:, :2]).convex_hull
            low, high = corners[:, 2].min(), corners[:, 2].max()
            covers = [layer.polygon for layer in layers if layer.low_m <= low + 1e-6 and layer.high_m >= high - 1e-6]
            assert outline.difference(shapely.union_all(covers).buffer(1e-6)).area < 1e-9


def test_a_swept_space_needs_the_other_joints_of_its_chain_at_rest(library: AssetLibrary):
    turned = library.geometry(asset("microwave"), state=(("turn", 1.0),)).posed
    assert turned is not None
    assert swept_space(turned, "door")[0] == ("door",)  # the plate is beside the door
    tilted = library.geometry(asset("chest"), state=(("lid", 0.5),)).posed
    assert tilted is not None
    with pytest.raises(InvalidInput, match="sweeps is not known"):
        swept_space(tilted, "lid")
    with pytest.raises(InvalidInput, match="no collision shape"):
        swept_space(turned, "turn")


def posed_slides(*joints: MechanismJoint, state: JointState, swept: str) -> PosedAsset:
    """Slides along x between links that the joints name, one of them with a swept volume of a cube of 1 dm at 0."""
    links = tuple(dict.fromkeys(name for joint in joints for name in (joint.parent, joint.child)))
    square = AnchorPolygon(outline_m=((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)))
    volume = SweptVolume(prisms=(SweptPrism(polygon=square, low_m=0.0, high_m=0.1),), volume_m3=1e-3)
    mechanism = Mechanism(tuple(MechanismLink(name, np.zeros(3)) for name in links), joints)
    return PosedAsset("slides", Linkage("slides", mechanism, ()), state, {swept: volume})


def slide(name: str, parent: str, leader: str | None = None, rest: float = 0.0) -> MechanismJoint:
    coupling = None if leader is None else JointCoupling(leader)
    limits = (0.0, 1.0)
    return MechanismJoint(name, "prismatic", parent, name, np.zeros(3), np.eye(3)[0], rest, limits, coupling=coupling)


def test_a_joint_written_at_rest_is_at_rest():
    """A rest of 0.1 m is 0.10000000149 m in the single precision of a package."""
    inner = slide("inner", "outer", rest=float(np.float32(0.1)))
    posed = posed_slides(slide("outer", "case"), inner, state=(("inner", 0.1),), swept="outer")
    links, (layer,) = swept_space(posed, "outer")
    assert links == ("outer", "inner")
    assert layer.polygon.bounds == (0.0, 0.0, 0.1, 0.1)


def test_a_swept_space_moves_with_what_carries_its_joint():
    joints = slide("tray", "case"), slide("lid", "tray"), slide("latch", "tray", "lid")
    _, (layer,) = swept_space(posed_slides(*joints, state=(("tray", 0.3),), swept="lid"), "lid")
    assert layer.polygon.bounds == pytest.approx((0.3, 0.0, 0.4, 0.1))


def test_followers_on_a_link_that_has_moved_elsewhere_sweep_an_unknown_space():
    """`latch` follows `lid` but is on `tray`: with the tray out, its part of the recorded space is elsewhere."""
    joints = slide("lid", "case"), slide("tray", "case"), slide("latch", "tray", "lid")
    assert swept_space(posed_slides(*joints, state=(("lid", 0.5),), swept="lid"), "lid")[0] == ("lid", "latch")
    with pytest.raises(InvalidInput, match="`latch`, which follows it, is on `tray`"):
        swept_space(posed_slides(*joints, state=(("tray", 0.3),), swept="lid"), "lid")


def test_a_joint_of_a_loop_sweeps_an_unknown_space(library: AssetLibrary):
    """The record takes the other joints to be at rest, which they cannot be while one joint of the loop moves."""
    posed = library.geometry(asset("four_bar")).posed
    assert posed is not None
    volume = posed_slides(slide("a", "b"), state=(), swept="left").swept
    with pytest.raises(InvalidInput, match="`closing` closes a loop"):
        swept_space(replace(posed, swept=volume), "left")


def test_a_follower_whose_coupling_has_an_offset_is_where_its_positions_say(tmp_path: Path):
    chest(tmp_path, "latched", latch_offset_m=0.02)
    geometry = AssetLibrary(tmp_path).geometry(asset("latched"))
    assert dict(geometry.joints) == {"lid": 0.0, "latch": pytest.approx(0.02)}
    latch = next(shape for shape in geometry.shapes if shape.size_m == pytest.approx((0.01, 0.04, 0.03)))
    assert latch.X_AS[2, 3] == pytest.approx(0.15 - 0.02, abs=1e-6)  # it slides down


def test_what_tips_over_is_found(library: AssetLibrary):
    shut = library.geometry(asset("drawer_unit")).posed
    opened = library.geometry(asset("drawer_unit"), state=(("drawer_1", 0.25), ("drawer_2", 0.25))).posed
    assert shut is not None
    assert opened is not None
    assert shut.beyond_feet_m() < opened.beyond_feet_m() < 0.0
    heavy = replace(opened.body, mass=replace(opened.body.mass, centre_of_mass_m=np.array([0.2, 0.0, 0.2])))
    assert beyond_feet_m(heavy) == pytest.approx(0.2 - 0.16)  # the bottom reaches to x = 0.16


def test_a_record_that_does_not_fit_its_package_is_told(library: AssetLibrary):
    posed = library.geometry(asset("microwave")).posed
    assert posed is not None
    empty = replace(posed, swept={"door": SweptVolume(prisms=(), volume_m3=0.0)})
    with pytest.raises(InvalidInput, match="an empty one"):
        swept_space(empty, "door")
    surface = SupportSurface.model_validate(surface_of("x", (0.0, 0.0, 0.1), (0.1, 0.1), "hatch"))
    with pytest.raises(InvalidInput, match="names a link `hatch`"):
        posed.anchor(surface)
