"""The envelope holds every point of everything that moves at every time; room and insertion keep off it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from shapely.geometry import LineString, Point, Polygon, box

from geom.convex.circumscribed_hull import circumscribed_hull
from geom.minkowski import eroded, minkowski_difference
from geom.pose import apply, pose
from replay.augmentation import prepare, variants
from replay.envelope.envelope import Settings, swept_envelope
from replay.envelope.simplify import simplify
from replay.insertion.candidates import InsertionCandidate, VariantChoices
from replay.insertion.free_space import FreeSpace, buffered, obstacles
from replay.insertion.supports import supports, used_supports
from replay.recording.episode import Camera, Episode, Fixture, FreeBody, Link, Robot
from replay.recording.formats.read import read_episode
from replay.verification.dense import dense_motion
from replay.verification.inserted_bodies import inserted_body
from replay.verification.verify import near_pairs
from replay.views.visible_area import area_in_view, in_picture
from schemas.diagnostics import InvalidInput
from schemas.physics import CollisionShape
from schemas.scene.runtime_plan import PlanBody
from tests.support.plan.library import box_body
from tests.support.replay_samples import staged


@pytest.fixture(scope="module")
def episode(tmp_path_factory):
    return read_episode(staged(tmp_path_factory.mktemp("arm")))


@pytest.fixture(scope="module")
def prepared(episode):
    return prepare(episode, Settings())


def only(body: PlanBody):
    return lambda seed, number: VariantChoices([InsertionCandidate(body, body.stances[0])] * 12)


def test_every_corner_lies_in_the_envelope_at_sixteen_times_between_rows(episode):
    """Linear and cubic motion as the verifier has it, without the clearance."""
    found = swept_envelope(episode, Settings(clearance_m=0.0))
    for stretch in dense_motion(episode):
        for moving in [body for body in stretch.bodies if body.name in found.bodies]:
            mine = found.body == found.bodies.index(moving.name)
            a, b, radius = found.start_W[mine], found.end_W[mine], found.radius_m[mine]
            for shape in moving.shapes:
                corners = np.concatenate([apply(X, circumscribed_hull(shape)) for X in moving.X_WB])
                assert distance_beyond(corners, a, b, radius) <= 1e-9


def distance_beyond(points, a, b, radius):
    along = b - a
    share = np.einsum("pci,ci->pc", points[:, None] - a, along) / np.maximum((along**2).sum(axis=1), 1e-300)
    nearest = a + np.clip(share, 0.0, 1.0)[:, :, None] * along
    return float((np.linalg.norm(points[:, None] - nearest, axis=2) - radius).min(axis=1).max())


def of(one: Robot | FreeBody, t_s):
    """An episode with nothing else in it."""
    robots = (one,) if isinstance(one, Robot) else ()
    objects = (one,) if isinstance(one, FreeBody) else ()
    return Episode("one", Path("one"), t_s, robots, objects, (), ())


BAR = CollisionShape("box", (0.6, 0.04, 0.04), np.eye(4))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_half_a_turn_is_covered_whichever_way_round(side):
    """Between two rows that are half a turn apart nobody knows the way; the envelope took one of the two."""
    shape = CollisionShape("box", (0.1, 0.04, 0.04), pose(None, np.array([0.3, 0.0, 0.0])))
    ends = np.stack([pose(Rotation.from_euler("z", a).as_matrix(), np.zeros(3)) for a in (0.0, side * np.pi)])
    found = swept_envelope(of(FreeBody("bar", ends, (shape,)), np.array([0.0, 0.1])), Settings(clearance_m=0.0))
    way = [pose(Rotation.from_euler("z", a).as_matrix(), np.zeros(3)) for a in np.linspace(0.0, side * np.pi, 50)]
    corners = np.concatenate([apply(X, circumscribed_hull(shape)) for X in way])
    assert distance_beyond(corners, found.start_W, found.end_W, found.radius_m) <= 1e-9


@pytest.mark.parametrize("jump_rad", [1e6, 1e100])
def test_a_joint_that_leaps_makes_capsules_wide_not_many(jump_rad):
    """Angles in other units, say: the division of the interval took all memory."""
    link = Link("bar", -1, "revolute", np.array([0.0, 0.0, 1.0]), np.eye(4), 0, shapes=(BAR,))
    q = np.array([[0.0], [0.1], [jump_rad]])
    arm = Robot("arm", (link,), ("j",), np.tile(np.eye(4), (3, 1, 1)), q)
    found = swept_envelope(of(arm, np.array([0.0, 0.1, 0.2])), Settings(protrusion_m=0.05))
    first = found.t_to_s <= 0.1
    assert found.radius_m[first].max() < 0.2
    assert found.radius_m[~first].min() > 1.0
    assert len(found.body) < 20_000


def test_the_ledger_names_body_and_time(episode):
    found = swept_envelope(episode, Settings())
    assert set(found.bodies) == {"upper", "lower", "cube"}
    assert (found.t_from_s <= found.t_to_s).all()
    assert found.t_from_s.min() == episode.t_s[0]
    assert found.t_to_s.max() == episode.t_s[-1]
    assert found.simplification_m.max() <= Settings().simplification_m
    parts = found.proxy_m + found.gap_m + found.interval_m + found.simplification_m
    np.testing.assert_allclose(found.radius_m, parts + 0.01)


@settings(max_examples=20)
@given(st.integers(0, 10_000), st.floats(0.001, 0.3))
def test_simplified_polylines_stay_within_the_tolerance(seed, tolerance_m):
    points = np.cumsum(np.random.default_rng(seed).normal(size=(3, 40, 3)) * 0.05, axis=1)
    spans = simplify(points, tolerance_m)
    for line in range(3):
        mine = spans.line == line
        assert spans.first[mine].tolist() == [0, *spans.last[mine].tolist()[:-1]]
        assert spans.last[mine][-1] == 39
        for first, last, said in zip(spans.first[mine], spans.last[mine], spans.deviation_m[mine], strict=True):
            chord = LineString(points[line, [first, last]][:, :2])  # seen from above no farther than in space
            assert max(chord.distance(Point(p[:2])) for p in points[line, first : last + 1]) <= said + 1e-9
            assert said <= tolerance_m


def test_erosion_of_a_room_with_a_corner_and_a_hole():
    """An L of 3 squares less a hole, eroded by a rectangle: by hand."""
    region = Polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]).difference(box(0.4, 0.4, 0.6, 0.6))
    outline = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.1], [0.0, 0.1]])  # its origin in a corner
    wanted = Polygon([(0, 0), (1.8, 0), (1.8, 0.9), (0.8, 0.9), (0.8, 1.9), (0, 1.9)]).difference(
        box(0.2, 0.3, 0.6, 0.6)
    )
    assert eroded(region, outline).symmetric_difference(wanted).area == pytest.approx(0.0, abs=1e-12)
    assert eroded(Polygon(), outline).is_empty


def test_an_outline_meets_a_convex_obstacle_where_erosion_by_it_leaves_no_room():
    obstacle, outline = Point(0.1, 0.2).buffer(0.3, quad_segs=3), np.array([[0, 0], [0.2, 0], [0.1, 0.3]])
    free_space = box(-1, -1, 2, 2)
    apart = eroded(free_space, outline).difference(minkowski_difference(obstacle, outline))
    assert apart.symmetric_difference(eroded(free_space.difference(obstacle), outline)).area < 1e-9


def test_supports_are_level_faces_and_those_used_come_first(episode):
    known = supports(episode)
    assert [s.name for s in known] == ["floor", "top"]
    assert known[1].height_m == pytest.approx(0.22)
    assert known[1].area.area == pytest.approx(0.8 * 1.2)
    assert [s.name for s in used_supports(episode, known)] == ["top"]
    with pytest.raises(InvalidInput, match="no support 'shelf'") as refused:
        prepare(episode, Settings(), ["shelf"])
    assert refused.value.diagnostic.code == "replay/no-support"


@pytest.mark.parametrize("roll_rad", [0.0, np.pi / 32.0])
def test_a_lying_cylinder_is_no_support(roll_rad):
    """Rolled by half a step, a side of the polygon around it was taken for a level face."""
    lies = Rotation.from_euler("y", 0.5 * np.pi) * Rotation.from_euler("z", roll_rad)
    log = CollisionShape("cylinder", (0.5, 1.0), pose(lies.as_matrix(), np.array([0.0, 0.0, 0.5])))
    stump = CollisionShape("cylinder", (0.5, 1.0), pose(None, np.array([2.0, 0.0, 0.5])))
    fixture = Fixture("wood", np.eye(4), (log, stump), ("log", "stump"))
    assert [s.name for s in supports(Episode("wood", Path("wood"), np.zeros(1), (), (), (fixture,), ()))] == ["stump"]


def test_things_of_a_plan_go_to_the_support_that_stands_for_their_place(episode):
    found = prepare(episode, Settings(), ["desk=top", "floor"])
    assert [(site.free_space.support.name, set(site.places)) for site in found.sites] == [
        ("floor", {"floor"}),
        ("top", {"top", "desk"}),
    ]
    body = box_body("crate", 0.08, 0.05, 0.1)
    for place, wanted in (("desk", {"top"}), ("floor", {"floor"})):
        choices = VariantChoices([InsertionCandidate(body, body.stances[0], place=place)] * 12)
        made = list(variants(found, lambda seed, number, c=choices: c, range(8), 3, seed=0))
        assert {one.support for v in made for one in v.inserted} == wanted


def test_room_is_less_the_taller_the_object_and_says_who_takes_it(prepared):
    free_space = prepared.sites[0].free_space
    free = [free_space.free(top_m).area for top_m in (0.02, 0.06, 0.1)]
    assert free == sorted(free, reverse=True)
    assert 0.0 < free[-1] < free[0] < free_space.support.area.area
    assert set(free_space.blocked_by(0.1)) == {"cube", "lower", "upper"}


def test_inserted_objects_are_clear_at_all_times_by_the_other_code(prepared, episode):
    body = box_body("crate", 0.08, 0.05, 0.1, mass_kg=0.2)
    made = list(variants(prepared, only(body), range(6), 4, seed=3))
    assert [len(v.inserted) for v in made] == [4] * 6
    bodies = [[inserted_body(one, None) for one in variant.inserted] for variant in made]
    for near in near_pairs(episode, bodies, 0.01):
        assert near[0].distance_m >= 0.01
    poses = [one.position_m for variant in made for one in variant.inserted]
    assert len(set(poses)) == len(poses)


def test_a_variant_depends_on_its_number_alone(prepared):
    body = box_body("crate", 0.08, 0.05, 0.1)
    whole = list(variants(prepared, only(body), range(4), 2, seed=5))
    assert list(variants(prepared, only(body), [3], 2, seed=5)) == whole[3:]
    assert next(iter(variants(prepared, only(body), [3], 2, seed=6))) != whole[3]


def test_what_does_not_fit_is_not_put(prepared):
    table = box_body("table", 0.9, 0.9, 0.3)
    assert next(iter(variants(prepared, only(table), [0], 2, seed=0))).inserted == ()


def test_a_camera_sees_the_part_of_a_plane_in_its_picture():
    above = Camera("above", pose(None, np.array([0.0, 0.0, 1.0]))[None], np.radians(90.0), 200, 100)
    found = area_in_view((above,), 0.0, box(-3, -3, 3, 3))
    assert found.symmetric_difference(box(-2, -1, 2, 1)).area == pytest.approx(0.0, abs=1e-9)
    assert in_picture(above, np.array([[1.9, 0.9, 0.0]]))
    assert not in_picture(above, np.array([[2.1, 0.9, 0.0], [0.0, 0.0, 2.0]]))


@pytest.mark.parametrize("corners", [3, 7, 10, 16, 17, 23, 64])
def test_outlines_grow_by_no_less_than_asked_at_any_corner(corners):
    """At 16 and 17 corners one chord stood for the whole arc around a corner: 1 % too near."""
    turn = np.arange(corners) * 2.0 * np.pi / corners
    outline = Polygon(0.05 * np.stack([np.cos(turn), np.sin(turn)], axis=1))
    around = buffered(outline, 0.01)
    assert 0.01 <= outline.distance(around.boundary) <= 0.0101


def test_still_links_are_obstacles(episode):
    assert "arm" in {one.name for one in obstacles(episode)}
    assert isinstance(
        FreeSpace(supports(episode)[0], swept_envelope(episode, Settings()), obstacles(episode)), FreeSpace
    )


def test_what_hides_too_much_of_the_task_is_drawn_again_or_left_out(episode):
    """Walls before a camera that looks along the table at the cube."""
    [front] = episode.cameras
    low = front.X_WC - 0.5 * np.outer([0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0])
    watched = prepare(replace(episode, cameras=(replace(front, X_WC=low),)), Settings())
    wall = box_body("wall", 0.05, 0.3, 0.3)
    free, held = (list(variants(watched, only(wall), range(4), 3, seed=1, most_hidden=most)) for most in (1.0, 0.05))
    assert max(max(v.camera_hidden.values(), default=0.0) for v in free) > 0.05
    assert all(max(v.camera_hidden.values(), default=0.0) <= 0.05 for v in held)
