"""Links that overlap at rest: slight overlaps are cut away, deep ones and those that scrape in motion are filtered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from assetkit.physics.link_clearance import GAP_SHARE, OVERLAP_SHARE, TOUCH_SHARE, Clearance, clear_links
from geom.convex.hull import volume
from geom.convex.penetration import penetration
from geom.convex.support_function import surface
from geom.pose import pose
from schemas.mechanism import Mechanism, MechanismJoint, MechanismLink
from schemas.physics import CollisionShape
from tests.support.package_samples import box_mesh, hull_shape

SIZE = np.array([0.2, 0.2, 0.2])
DIAGONAL = float(np.linalg.norm(SIZE))


def shape(x_m: float, kind: str = "hull") -> CollisionShape:
    if kind == "hull":
        return hull_shape(box_mesh(tuple(SIZE), shift=(x_m, 0.0, 0.0)))
    sizes = {"box": tuple(SIZE), "sphere": (0.1,)}
    return CollisionShape(kind, sizes[kind], pose(None, (x_m, 0.0, 0.1)))  # pyright: ignore[reportArgumentType]


def mechanism(axis: Sequence[float] = (0.0, 0.0, 1.0), *, joined: bool = False) -> Mechanism:
    """Links `a` and `b`; `b` slides along `axis` against the base, or against `a`."""
    links = tuple(MechanismLink(name, np.zeros(3)) for name in ("base", "a", "b"))
    still = MechanismJoint("still", "prismatic", "base", "a", np.zeros(3), np.array([0.0, 1.0, 0.0]), limits=(0.0, 0.0))
    parent = "a" if joined else "base"
    slide = MechanismJoint("slide", "prismatic", parent, "b", np.zeros(3), np.asarray(axis), limits=(0.0, 0.3))
    return Mechanism(links, (still, slide))


def cleared(overlap_m: float, kind: str = "hull", of: Mechanism | None = None) -> Clearance:
    base = hull_shape(box_mesh((0.1, 0.1, 0.1), shift=(0.0, 0.0, -1.0)))
    links = {"base": [base], "a": [shape(0.0, kind)], "b": [shape(0.2 - overlap_m, kind)]}
    return clear_links(links, of or mechanism())


@pytest.mark.parametrize("kind", ["hull", "box"])
def test_a_slight_overlap_is_cut_away_in_equal_parts_and_recorded(kind: str) -> None:
    overlap = 0.5 * OVERLAP_SHARE * DIAGONAL
    result = cleared(overlap, kind, mechanism((-1.0, 0.0, 0.0)))
    assert result.filtered_pairs == ()
    a, b = (surface(result.shapes[name][0])[0] for name in ("a", "b"))
    gap = GAP_SHARE * DIAGONAL
    assert a[:, 0].max() == pytest.approx(0.1 - 0.5 * (overlap + gap), abs=1e-9)
    assert b[:, 0].min() - a[:, 0].max() == pytest.approx(gap, abs=1e-9)
    assert penetration(a, b)[0] == 0.0
    cut = result.shapes["a"][0]
    assert cut.points is not None
    assert cut.triangles is not None
    assert volume(cut.points, cut.triangles) == pytest.approx(0.04 * (0.2 - 0.5 * (overlap + gap)), rel=1e-9)
    (repair,) = result.repairs
    assert (repair.name, repair.code) == ("collider_trim", "asset/colliders-trimmed")
    assert repair.before["overlap_m"] == pytest.approx(overlap)
    assert repair.after["overlap_m"] == 0.0
    assert [d.code for d in result.diagnostics] == ["asset/colliders-trimmed"]


@pytest.mark.parametrize("kind", ["hull", "sphere"])
def test_a_deep_overlap_is_filtered_and_said(kind: str) -> None:
    overlap_m = 0.03
    result = cleared(overlap_m, kind)
    assert result.filtered_pairs == (("a", "b"),)
    assert result.repairs == ()
    (note,) = result.diagnostics
    assert note.code == "asset/links-filtered"
    assert note.value == pytest.approx(overlap_m, rel=0.5)


def test_links_that_are_apart_are_left_alone_and_those_that_slide_touching_are_filtered() -> None:
    """1 mm is more than what counts as touching, 0.35 mm of 0.35 m; a link that meets the other head-on is none."""
    result = cleared(-0.001)
    assert (result.filtered_pairs, result.repairs, result.diagnostics) == ((), (), ())
    assert cleared(-0.5 * TOUCH_SHARE * DIAGONAL).filtered_pairs == (("a", "b"),)
    assert cleared(0.0, of=mechanism((-1.0, 0.0, 0.0))).filtered_pairs == ()


def test_links_that_scrape_along_each_other_are_filtered() -> None:
    """One slides past the other, 1 in 300 towards it: 0.3 mm are cut, 1 mm comes in motion."""
    result = cleared(0.0003, of=mechanism((-1.0 / 300.0, 0.0, 1.0)))
    assert result.filtered_pairs == (("a", "b"),)
    into = cleared(0.0003, of=mechanism((-1.0, 0.0, 0.0)))  # a real stop
    assert into.filtered_pairs == ()


def test_a_cut_that_would_take_half_of_a_shape_is_none() -> None:
    thin = hull_shape(box_mesh((0.0004, 0.2, 0.2), shift=(0.0998, 0.0, 0.0)))
    links = {"a": [shape(0.0)], "b": [thin, shape(0.4)]}
    joints = Mechanism(mechanism().links[1:], (mechanism(joined=True).joints[1],))
    assert clear_links(links, joints).filtered_pairs == (("a", "b"),)
