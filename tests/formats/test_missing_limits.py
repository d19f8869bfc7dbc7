"""Joints without stated limits: a slide ends where its link meets another, a hinge only where it does so both ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from formats.missing_limits import with_missing_limits
from geom.collision_free_range import collision_free_range
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from schemas.model import Mesh
from schemas.outcome import Repair
from tests.support.package_samples import box_mesh

SLIDE = MechanismJoint(
    "slide", "prismatic", "case", "tray", np.zeros(3), np.array([1.0, 0.0, 0.0]), rest=0.5, source_name="slide"
)
HINGE = replace(SLIDE, name="hinge", kind="continuous", axis=np.array([0.0, 0.0, 1.0]), rest=0.0, source_name="hinge")
FREE = Repair(name="free_hinge", code="robot/missing-limit", stage="intake", before={"joint": "hinge"})
TRAY = box_mesh((0.2, 0.1, 0.05), "tray", link="tray")


def mechanism(joint: MechanismJoint) -> Mechanism:
    return Mechanism((MechanismLink("case", np.zeros(3)), MechanismLink("tray", np.zeros(3))), (joint,))


def wall(x_m: float, y_m: float = 0.0, size: tuple[float, float, float] = (0.02, 0.5, 0.5)) -> Mesh:
    return box_mesh(size, f"wall{x_m}{y_m}", (x_m, y_m, -0.2), link="case")


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
def test_a_slide_ends_where_its_link_meets_the_other(scale: float) -> None:
    """Walls 0.15 and 0.4 m away: 0.15 - 0.01 - 0.1 to one side, to 0.1 % of the size."""
    meshes = [replace(m, points=m.points * scale) for m in (TRAY, wall(-0.15), wall(0.4))]
    joint = replace(SLIDE, rest=0.5 * scale)
    found, repairs = with_missing_limits(mechanism(joint), meshes)
    assert found.joints[0].limits == pytest.approx(((0.5 - 0.04) * scale, (0.5 + 0.29) * scale), abs=1e-3 * scale)
    assert found.joints[0].limits_inferred
    assert [r.name for r in repairs] == ["limit_by_collision"]
    assert repairs[0].before["limits"] == "none"


def test_a_slide_that_meets_nothing_may_go_as_far_as_the_object_is_large() -> None:
    meshes = [TRAY, box_mesh((0.1, 0.1, 0.02), "case", (0.0, 0.0, -0.1), link="case")]
    size = float(np.linalg.norm(np.ptp(np.concatenate([m.points for m in meshes]), axis=0)))
    found, repairs = with_missing_limits(mechanism(SLIDE), meshes)
    assert found.joints[0].limits == pytest.approx((0.5 - size, 0.5 + size))
    assert [r.name for r in repairs] == ["limit_by_size"]


def test_links_that_cross_at_rest_are_no_stop() -> None:
    found, repairs = with_missing_limits(mechanism(SLIDE), [TRAY, wall(0.05)])
    assert [r.name for r in repairs] == ["limit_by_size"]
    assert found.joints[0].limits is not None


def test_a_hinge_is_limited_only_where_it_meets_something_both_ways() -> None:
    """The corner of a tray of 0.1 x 0.05 m about its centre meets a board that begins 0.08 m from the axis."""
    boards = [wall(0.0, y, (0.02, 0.02, 0.2)) for y in (0.09, -0.09)]
    found, repairs = with_missing_limits(mechanism(HINGE), [TRAY, *boards], [FREE])
    joint = found.joints[0]
    assert (joint.kind, joint.limits_inferred) == ("revolute", True)
    low, high = joint.limits or (0.0, 0.0)
    assert low == pytest.approx(-high, abs=0.01)
    free = collision_free_range(mechanism(HINGE), HINGE, {"case": _surface(boards), "tray": _surface([TRAY])}, np.pi)
    assert (low, high) == pytest.approx(free, abs=0.05)
    assert [r.name for r in repairs] == ["limit_by_collision"]
    open_found, open_repairs = with_missing_limits(mechanism(HINGE), [TRAY, wall(1.0)], [FREE])
    assert open_found.joints[0].limits is None
    assert open_repairs == (FREE,)


def test_stated_limits_and_endless_hinges_are_left_alone() -> None:
    stated = replace(SLIDE, limits=(0.0, 5.0))
    assert with_missing_limits(mechanism(stated), [TRAY, wall(0.4)])[0].joints == (stated,)
    assert with_missing_limits(mechanism(HINGE), [TRAY, wall(0.0, 0.09)])[0].joints == (HINGE,)


def _surface(meshes: list[Mesh]) -> tuple[np.ndarray, np.ndarray]:
    starts = np.cumsum([0, *(len(m.points) for m in meshes)])
    triangles = [m.triangles + first for m, first in zip(meshes, starts, strict=False)]
    return np.concatenate([m.points for m in meshes]), np.concatenate(triangles)
