"""The table of joints in the report, from drawn mechanisms whose use is known, and its place on the page."""

from __future__ import annotations

from dataclasses import replace

import pytest
from jinja2 import Environment, PackageLoader, StrictUndefined

from assetkit.articulation.joint_uses import ArticulatedObject, joint_uses
from assetkit.batch.joint_rows import JointRow, joint_rows
from schemas.anchors import AnchorPolygon, SupportSurface
from schemas.articulation import JointUse, SweptVolume
from tests.support.mechanism.drawn_mechanisms import DrawnMechanism, drawer, hinged_door, knob

SQUARE = AnchorPolygon(outline_m=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))


DRAWER = drawer(0.5, 0.4, 0.2, handle=True, travel=0.8)


def uses_of(drawn: DrawnMechanism) -> tuple[JointUse, ...]:
    swept = SweptVolume(prisms=(), volume_m3=0.0125)
    return tuple(
        use.model_copy(update={"swept": swept}) for use in joint_uses(ArticulatedObject(drawn.mechanism, drawn.links))
    )


def joint(name: str, kind: str, parent: str, child: str, **limits: tuple[float, float]) -> dict[str, object]:
    return {"name": name, "type": kind, "parent": parent, "child": child, **limits}


def row_of(drawn: DrawnMechanism) -> JointRow:
    (moving,) = drawn.mechanism.joints
    key = "limits_rad" if moving.is_angular else "limits_m"
    limits = {} if moving.limits is None else {key: moving.limits}
    (row,) = joint_rows([joint(moving.name, moving.kind, moving.parent, moving.child, **limits)], uses_of(drawn), ())
    return row


def test_a_drawer_shows_group_way_and_handle_in_centimetres() -> None:
    row = row_of(DRAWER)
    (use,) = uses_of(DRAWER)
    assert row.group == "drawer"
    start, _, end = row.opens.removeprefix("open: ").partition(" to ")
    assert float(start) == pytest.approx(100.0 * use.closed.value)
    assert float(end.split()[0]) == pytest.approx(100.0 * use.open.value, rel=0.01)
    assert row.opens.endswith("cm (+)" if use.open.value > use.closed.value else "cm (−)")
    assert row.handle.startswith("handle (")
    assert row.swept_l == pytest.approx(12.5)


def test_angles_are_in_degrees_and_joints_without_limits_are_endless() -> None:
    door = hinged_door(0.5, 0.7, 0.4, handle=True, turn=1.5, left=True)
    assert row_of(door).range_text == "0 to 85.9°"
    assert row_of(knob(0.3, 0.08, 1.0, turn=3.0)).range_text == "0 to 172°"
    (endless,) = joint_rows([joint("spin", "revolute", "base", "disc")], (), ())
    assert (endless.range_text, endless.group, endless.opens, endless.swept_l) == ("endless", "", "", None)


def test_anchors_of_all_links_beyond_a_joint_follow_it() -> None:
    joints = [
        joint("slide", "prismatic", "base", "box", limits_m=(0.0, 0.3)),
        joint("lid", "revolute", "box", "lid", limits_rad=(0.0, 1.0)),
        joint("door", "revolute", "base", "door", limits_rad=(0.0, 1.0)),
    ]
    anchors = [
        SupportSurface(
            anchor_id=f"{link}/surface_0",
            link=link,
            position_m=(0, 0, 0),
            polygon=SQUARE,
            normal=(0, 0, 1),
            area_m2=1.0,
            clearance_m=None,
            load_directions=(),
        )
        for link in ("base", "lid", "box")
    ]
    carried = {row.name: row.carries for row in joint_rows(joints, (), anchors)}
    assert carried == {"slide": ("box/surface_0", "lid/surface_0"), "lid": ("lid/surface_0",), "door": ()}


def test_the_page_has_a_line_for_each_joint_and_marks_what_is_unsure() -> None:
    loader = PackageLoader("assetkit.batch", "templates")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("joints.html")
    row = row_of(DRAWER)
    unsure = replace(
        row, name="<spin>", group="rotary_knob", swept_l=None, carries=("disc/surface_0",), unsure=("group",)
    )
    html = page.render(card={"joints": (row, unsure)})
    first, second = html.split("<tr>")[2:]
    assert f"{row.swept_l:.3g} l" in first
    assert 'class="low"' not in first
    for value in (row.range_text, row.opens, row.handle, "drawer"):
        assert f">{value}<" in first
    assert "&lt;spin&gt;" in second
    assert '<td class="low">rotary knob</td>' in second
    assert "disc/surface_0" in second
    assert page.render(card={"joints": ()}).strip() == ""
