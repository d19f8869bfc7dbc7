"""Pictures: where things appear, in which colour, and the same every time."""

from __future__ import annotations

import colorsys
import dataclasses
import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image, ImageDraw

from geom.mesh.primitives import cube
from render import window
from render.__main__ import NO_OPENGL, main
from render.camera import FILL, HERO_VIEW, STANDARD_VIEWS, CameraView, annotation_frame, camera
from render.collision import shape_color
from render.request import RenderRequest
from render.studio import BACKGROUND_SRGB, contact_shadow
from render.textures import MAX_EDGE_PX, decode_rgba
from schemas.appearance.material import Material, Texture, TextureUse
from schemas.files import array_files
from schemas.model import Model
from schemas.physics import CollisionShape
from tests.support.drawn import (
    BACK,
    CORNERS,
    FRONT,
    LEFT,
    PX,
    QUAD,
    RED,
    at,
    box,
    image,
    lens,
    linear,
    model,
    pictures,
    png,
    textured,
    upright,
)

EDGES = st.floats(0.01, 1.0)


@settings(deadline=None, max_examples=60)
@given(st.tuples(EDGES, EDGES, EDGES), st.sampled_from([*STANDARD_VIEWS, HERO_VIEW]))
def test_the_camera_fits_the_box_exactly(size: tuple[float, float, float], view: CameraView) -> None:
    extent = np.array(size) / max(size)
    corners = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T * extent
    seen = camera(view, extent).project(corners, 2)
    assert np.abs(seen - 1.0).max() == pytest.approx(FILL)
    assert camera(view, extent).project(np.zeros((1, 3)), 100)[0] == pytest.approx([50.0, 50.0])


def test_axes_of_the_views() -> None:
    unit = np.ones(3)
    tip_x, tip_y, tip_z = np.eye(3) * 0.4
    for view, to_the_right in ((FRONT, tip_y), (LEFT, -tip_x), (BACK, -tip_y)):
        seen = camera(view, unit).project(np.array([to_the_right, tip_z]), 100)
        assert seen[0, 0] > 60.0
        assert seen[1, 0] == pytest.approx(50.0)
        assert seen[1, 1] < 40.0


def test_a_box_covers_the_pixels_the_camera_says_in_its_colour(tmp_path: Path) -> None:
    content = model(box((0.4, 0.2, 0.6), at=(3.0, -7.0, 0.3)), materials=(Material("red", base_color=RED),))
    seen = pictures(content, tmp_path, size_px=256)
    for view in STANDARD_VIEWS:
        picture = seen[view.name]
        covered = picture[..., 0] - picture[..., 1] > 60
        lens_of_view, points = lens(content, view)
        expected = Image.new("1", (256, 256))
        corners = lens_of_view.project(points, 256)
        ImageDraw.Draw(expected).polygon([tuple(p) for p in convex(corners)], fill=1)
        mask = np.asarray(expected)
        assert (covered & mask).sum() / (covered | mask).sum() > 0.97
        # The studio lights a matte face with about as much as it reflects: colours look like their swatch.
        assert linear(picture[covered]).mean(axis=0) == pytest.approx(RED, abs=0.15)


def convex(points: np.ndarray) -> list[np.ndarray]:
    """The convex hull of (n, 2) points, in order (gift wrapping)."""
    hull = [points[np.argmin(points[:, 0])]]
    while True:
        candidate = points[0]
        for p in points:
            turn = (candidate - hull[-1])[0] * (p - hull[-1])[1] - (candidate - hull[-1])[1] * (p - hull[-1])[0]
            if (candidate == hull[-1]).all() or turn < 0:
                candidate = p
        if (candidate == hull[0]).all():
            return hull
        hull.append(candidate)


@pytest.mark.parametrize("scale", [2.0**-10, 2.0**9])
def test_size_does_not_matter(scale: float, tmp_path: Path) -> None:
    content = model(box((0.4, 0.2, 0.6)), materials=(Material("red", base_color=RED),))
    scaled = dataclasses.replace(content.meshes[0], points=content.meshes[0].points * scale)
    first = pictures(content, tmp_path)
    second = pictures(model(scaled, materials=content.materials), tmp_path)
    assert all((first[name] == second[name]).all() for name in first)


def posed(kind: str, size: tuple[float, ...], at_m: tuple[float, float, float]) -> CollisionShape:
    pose = np.eye(4)
    pose[:3, 3] = at_m
    return CollisionShape(kind, size, pose)  # pyright: ignore[reportArgumentType]  # the Literal


def test_collision_shapes_show_each_in_its_colour(tmp_path: Path) -> None:
    hull = cube(0.3)
    shapes = (
        posed("box", (0.3, 0.3, 0.3), (0.0, -0.8, 0.5)),
        posed("sphere", (0.17,), (0.0, -0.4, 0.5)),
        posed("cylinder", (0.15, 0.3), (0.0, 0.0, 0.5)),
        posed("capsule", (0.12, 0.2), (0.0, 0.4, 0.5)),
        CollisionShape("hull", (), np.eye(4), hull.points + np.array([0.0, 0.8, 0.5]), hull.triangles.astype(np.int32)),
    )
    content = model(box((0.05, 2.0, 1.0), at=(0.0, 0.0, 0.5)), materials=(Material("grey"),))
    seen = pictures(content, tmp_path, shapes, size_px=256)
    plain = pictures(content, tmp_path, size_px=256)
    assert "collision" not in plain
    assert (seen["view_front"] == plain["view_front"]).all()
    for index, shape in enumerate(shapes):
        middle = (0.16, 0.8 if shape.kind == "hull" else shape.X_AS[1, 3], 0.5)
        color = at(seen["collision"], content, HERO_VIEW, middle)
        hue = colorsys.rgb_to_hsv(*(color / 255.0))[0]
        expected = colorsys.rgb_to_hsv(*shape_color(index))[0]
        assert min(abs(hue - expected), 1.0 - abs(hue - expected)) < 0.05, shape.kind
        assert np.ptp(color) > 25


def test_the_same_bytes_in_every_process(tmp_path: Path) -> None:
    glass = Material("glass", base_color=RED, opacity=0.4, alpha_mode="blend")
    content = dataclasses.replace(textured(TextureUse("corners")), meshes=(upright(), box((1, 1, 1), material=1)))
    content = dataclasses.replace(content, materials=(*content.materials, glass))
    shapes = (posed("sphere", (0.5,), (0.0, 0.0, 0.5)), posed("box", (1.0, 0.5, 0.5), (0.0, 0.0, 0.5)))
    written = []
    for name in ("first", "second"):
        request = RenderRequest(content, shapes, str(tmp_path / name), PX)
        array_files.save(request, RenderRequest, tmp_path / f"{name}.npz")
        command = [sys.executable, "-m", "render", "previews", str(tmp_path / f"{name}.npz")]
        subprocess.run(command, check=True, timeout=60, cwd=Path(__file__).parents[2])
        written.append({path.name: path.read_bytes() for path in sorted((tmp_path / name).iterdir())})
    assert written[0] == written[1]
    assert set(written[0]) == {f"{v.name}.png" for v in STANDARD_VIEWS} | {"thumbnail.png", "collision.png"}
    assert Image.open(tmp_path / "first" / "thumbnail.png").size == (256, 256)
    assert not any(b"tIME" in data or b"tEXt" in data for data in written[0].values())


@pytest.mark.parametrize(
    "content",
    [
        model(),
        model(dataclasses.replace(upright(), triangles=QUAD[:0], uvs=(), material=None)),
        model(dataclasses.replace(upright(), points=upright().points * np.nan, material=None)),
        model(dataclasses.replace(upright(), points=upright().points * 0.0, material=None)),
        model(upright(), materials=(Material("m", base_color_texture=TextureUse("absent")),)),
        model(
            upright(),
            materials=(Material("m", base_color_texture=TextureUse("broken")),),
            textures=(Texture("broken", b"no image", "png", 1, 1),),
        ),
        model(
            dataclasses.replace(upright(), uvs=()),
            materials=(Material("m", base_color_texture=TextureUse("c", uv_set=1)),),
            textures=(image("c", CORNERS),),
        ),
    ],
    ids=["no mesh", "no triangle", "not finite", "a point", "absent texture", "broken texture", "no coordinates"],
)
def test_poor_models_still_give_pictures(content: Model, tmp_path: Path) -> None:
    seen = pictures(content, tmp_path, size_px=32)
    assert set(seen) == {*(v.name for v in STANDARD_VIEWS), "thumbnail"}
    assert (seen["view_top"][0] == BACKGROUND_SRGB).all()


def test_needles_are_not_lost_between_samples(tmp_path: Path) -> None:
    content = model(box((0.001, 0.001, 1.0)), materials=(Material("red", base_color=RED),))
    picture = pictures(content, tmp_path)["view_front"]
    rows = (picture[..., 0] - picture[..., 1] > 40).any(axis=1)
    assert rows.sum() > 0.8 * PX


def test_missing_opengl_is_an_exit_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    array_files.save(RenderRequest(model(upright()), (), str(tmp_path)), RenderRequest, tmp_path / "r.npz")
    monkeypatch.setattr(window, "_loads", lambda library: False)
    written = io.StringIO()
    monkeypatch.setattr(sys, "stderr", written)
    assert main(["previews", str(tmp_path / "absent.npz")]) == 2
    array_files.save(RenderRequest(model(), (), str(tmp_path)), RenderRequest, tmp_path / "r.npz")
    assert main(["previews", str(tmp_path / "r.npz")]) == NO_OPENGL
    assert "libosmesa6" in written.getvalue()


def test_textures_shrink_and_keep_their_values() -> None:
    wide = decode_rgba(png(np.full((600, 4096, 3), 77, dtype=np.uint8)))
    assert wide is not None
    assert wide.shape == (150, MAX_EDGE_PX, 4)
    assert (wide[..., :3] == 77).all()
    deep = decode_rgba(png(np.full((4, 4), 30000, dtype=np.uint16)))
    assert deep is not None
    assert (deep[..., 0] == 30000 >> 8).all()
    flag = decode_rgba(png(np.array([[[255, 0, 0]], [[0, 255, 0]]], dtype=np.uint8)))
    assert flag is not None
    assert flag[0, 0, 1] == 255  # the first row is the bottom one


def test_shadows_lie_under_what_stands_low() -> None:
    assert (contact_shadow(np.zeros((0, 3)), 0.0) == 0.0).all()
    low = contact_shadow(np.array([[0.4, 0.0, 0.0]]), 0.0)
    high = contact_shadow(np.array([[0.4, 0.0, 0.9]]), 0.0)
    row, column = np.unravel_index(np.argmax(low), low.shape)
    assert (row, column) == (64, 80)
    assert low.max() > 2.0 * high.max() > 0.0


def test_the_annotation_frame_is_centred_with_largest_edge_one() -> None:
    frame = annotation_frame(np.array([1.0, 2.0, 3.0]), np.array([3.0, 3.0, 7.0]))
    corners = frame.from_asset(np.array([[1.0, 2.0, 3.0], [3.0, 3.0, 7.0]]))
    assert corners == pytest.approx(np.array([[-0.25, -0.125, -0.5], [0.25, 0.125, 0.5]]))
    assert frame.extent == pytest.approx([0.5, 0.25, 1.0])
