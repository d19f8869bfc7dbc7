"""Cameras of samples: within their ranges, views show what they must by two counts, a scene without view is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geom.pose import matrix_of
from runtime_plan import as_document, sample
from runtime_plan.camera_rays import visible_pixels
from runtime_plan.cameras import bodies_of, draw_cameras
from runtime_plan.plan import Plan, prepare
from scene_check.views import pixels_by_object
from scenec.check.judge_views import plan_without_view
from scenec.compile import Compiled, compile_program
from schemas.diagnostics import InvalidInput
from source.tree import Spans

PROGRAM = (Path(__file__).parents[1] / "data" / "scenes" / "cameras.yaml").read_text()


def compiled_from(folder: Path, text: str = PROGRAM, diversity: float | None = None) -> Compiled:
    (folder / "program.yaml").write_text(text)
    return compile_program(folder / "program.yaml", diversity=diversity)


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    compiled = compiled_from(tmp_path_factory.mktemp("cameras"), diversity=0.1)
    assert compiled.plan is not None
    return prepare(compiled.plan)


def test_every_draw_shows_the_cup_and_both_counts_agree(plan: Plan):
    samples = sample(plan, 60, 11)
    for k in range(60):
        bodies = bodies_of(plan, samples, k)
        prisms = {name: body.prisms for name, body in bodies.items()}
        others = [prism for name, pieces in prisms.items() if name != "cup" for prism in pieces]
        for name, camera in draw_cameras(plan, samples, k).items():
            seen = pixels_by_object(camera, prisms)["cup"]
            assert seen >= {"front": 60, "wrist": 400}[name]
            assert abs(seen - visible_pixels(camera, prisms["cup"], others)) <= 2


def test_cameras_use_their_ranges_and_aim_where_they_should(plan: Plan):
    samples = sample(plan, 150, 11)
    drawn = [draw_cameras(plan, samples, k) for k in range(150)]
    places = np.array([cameras["front"].position_m for cameras in drawn])
    low, high = np.array([-0.3, -1.0, 0.4]), np.array([0.3, -0.8, 0.7])
    assert (places >= low).all()
    assert (places <= high).all()
    assert (np.ptp(places, axis=0) > 0.8 * (high - low)).all()
    fields = [cameras["front"].fov_deg for cameras in drawn]
    assert 45.0 <= min(fields) < 46.0
    assert 54.0 < max(fields) <= 55.0
    cup = samples.position_m[:, samples.names.index("cup")] + [0.0, 0.0, 0.05]
    for middle, cameras in zip(cup, drawn, strict=True):
        at = (middle - cameras["wrist"].position_m) @ matrix_of(np.array(cameras["wrist"].quat_wxyz))
        np.testing.assert_allclose(at[:2], 0.0, atol=1e-6)
        assert at[2] < 0.0


def test_a_camera_beside_an_object_turns_with_it(plan: Plan):
    samples = sample(plan, 30, 11)
    column = samples.names.index("cup")
    for k in range(30):
        w, _, _, z = samples.quat_wxyz[k, column]
        away = np.array(draw_cameras(plan, samples, k)["wrist"].position_m) - samples.position_m[k, column]
        c, s = np.cos(-2.0 * np.arctan2(z, w)), np.sin(-2.0 * np.arctan2(z, w))
        x, y = c * away[0] - s * away[1], s * away[0] + c * away[1]
        assert -0.02 - 1e-9 <= x <= 0.02 + 1e-9
        assert -0.25 - 1e-9 <= y <= -0.2 + 1e-9


def test_draws_depend_on_seed_and_index_alone_and_are_in_files(plan: Plan):
    whole, part = sample(plan, 8, 3), sample(plan, 2, 3, start=6)
    assert draw_cameras(plan, whole, 7) == draw_cameras(plan, part, 1)
    assert as_document(plan, part).samples[1].cameras == draw_cameras(plan, part, 1)


def test_a_moved_camera_is_refused_by_the_z_buffer(plan: Plan):
    samples = sample(plan, 1, 3)
    bodies = {name: body.prisms for name, body in bodies_of(plan, samples, 0).items()}
    camera = draw_cameras(plan, samples, 0)["front"]
    under = camera.model_copy(update={"position_m": (camera.position_m[0], camera.position_m[1], -0.5)})
    assert pixels_by_object(under, bodies)["cup"] < 60  # the table is in the way


def test_a_scene_without_view_is_named(plan: Plan):
    demand = plan.document.cameras[0].visible[0].model_copy(update={"pixels": 15_000})
    camera = plan.document.cameras[0].model_copy(update={"visible": (demand,)})
    strict = prepare(plan.document.model_copy(update={"cameras": (camera,)}))
    with pytest.raises(InvalidInput) as refused:
        draw_cameras(strict, sample(strict, 1, 3), 0)
    assert refused.value.diagnostic.code == "plan/no-view"


def test_the_compiler_names_the_share_of_scenes_without_a_view(plan: Plan):
    (rule,) = plan.document.cameras[1].visible
    camera = plan.document.cameras[1].model_copy(update={"visible": (rule.model_copy(update={"pixels": 15_000}),)})
    document = plan.document.model_copy(update={"cameras": (plan.document.cameras[0], camera)})
    (diagnostic,) = plan_without_view(document, 0, Spans())
    blocked = int(diagnostic.headline.split()[1])
    assert diagnostic.code == "scene/no-view"
    assert blocked == 64
    assert list(plan_without_view(plan.document, 0, Spans())) == []


def test_a_program_without_a_view_is_refused(tmp_path: Path):
    report = compiled_from(tmp_path, PROGRAM.replace("pixels: 400", "pixels: 19000")).report
    assert report.verdict == "invalid_program"
    assert [d.code for d in report.diagnostics] == ["scene/no-view"]
    assert report.diagnostics[0].where.line is not None


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("look_at: cup", "look_at: cub", "scene/unknown-name"),
        ("id: wrist", "id: front", "scene/duplicate-id"),
        ("fov_deg: [45, 55]", "fov_deg: [55, 45]", "scene/range-reversed"),
        ("fov_deg: [45, 55]", "fov_deg: [45, 200]", "scene/invalid-value"),
        ("pixels: 60", "pixels: 0", "scene/invalid-value"),
        ("y: [-1.0, -0.8], ", "", "scene/missing-key"),
    ],
)
def test_cameras_are_checked(old: str, new: str, code: str, tmp_path: Path):
    report = compiled_from(tmp_path, PROGRAM.replace(old, new, 1)).report
    assert [d.code for d in report.diagnostics] == [code]
