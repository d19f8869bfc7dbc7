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

from geom.gprims import cube, sphere
from render import window
from render.__main__ import NO_OPENGL, main
from render.camera import FILL, HERO_VIEW, STANDARD_VIEWS, Camera, View, annotation_frame, camera
from render.collision import shape_color
from render.request import RenderRequest
from render.studio import BACKGROUND_SRGB, contact_shadow
from render.textures import MAX_EDGE_PX, decode_rgba
from render.views import model_frame, render_all
from schemas import arrays
from schemas.evidence import Evidence
from schemas.model import Material, Mesh, Model, Texture, TextureUse
from schemas.physics import CollisionShape

PX = 128
FRONT, LEFT, BACK, TOP = STANDARD_VIEWS
QUAD = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
UNIT_UVS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32)
RED = (0.6, 0.02, 0.02)


def model(*meshes: Mesh, materials: tuple[Material, ...] = (), textures: tuple[Texture, ...] = ()) -> Model:
    metres = Evidence[float](value=1.0, source="declared", method="test", confidence=1.0)
    up = Evidence(value="z", source="declared", method="test", confidence=1.0)
    return Model(meshes, materials, textures, (), metres, up)  # pyright: ignore[reportArgumentType]  # the Literal


def box(size: tuple[float, float, float], at: tuple[float, float, float] = (0, 0, 0), material: int | None = 0) -> Mesh:
    shape = cube(1.0)
    return Mesh(
        "box",
        shape.points * size + at,
        shape.triangles.astype(np.int32),
        shape.normals.astype(np.float32),
        (),
        None,
        material,
    )


def upright(uvs: np.ndarray = UNIT_UVS, x: float = 0.0, half: float = 1.0, material: int = 0) -> Mesh:
    """A square sheet that faces +x: seen from the front, +y is to the right and the u axis of `uvs` follows it."""
    points = np.array([[x, -half, 0], [x, half, 0], [x, half, 2 * half], [x, -half, 2 * half]], dtype=np.float64)
    return Mesh("sheet", points, QUAD, None, (uvs[QUAD],), None, material)


def png(pixels: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


def image(name: str, pixels: np.ndarray) -> Texture:
    return Texture(name, png(pixels.astype(np.uint8)), "png", pixels.shape[1], pixels.shape[0])


def pictures(
    content: Model, folder: Path, shapes: tuple[CollisionShape, ...] = (), size_px: int = PX
) -> dict[str, np.ndarray]:
    """(px, px, 3) int pictures by name."""
    paths = render_all(RenderRequest(content, shapes, str(folder), size_px))
    return {name: np.asarray(Image.open(path)).astype(int) for name, path in paths.items()}


def linear(srgb: np.ndarray) -> np.ndarray:
    value = np.asarray(srgb) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def lens(content: Model, view: View) -> tuple[Camera, np.ndarray]:
    """The camera of a view, and all points of the model in the annotation frame."""
    frame = model_frame(content)
    return camera(view, frame.extent), frame.from_asset(np.concatenate([mesh.points for mesh in content.meshes]))


def at(picture: np.ndarray, content: Model, view: View, point_m: tuple[float, float, float]) -> np.ndarray:
    """Mean colour of the 3 x 3 pixels around the place where `point_m` is seen."""
    frame = model_frame(content)
    x, y = camera(view, frame.extent).project(frame.from_asset(np.array([point_m])), len(picture))[0].astype(int)
    return picture[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3).mean(axis=0)


EDGES = st.floats(0.01, 1.0)


@settings(deadline=None, max_examples=60)
@given(st.tuples(EDGES, EDGES, EDGES), st.sampled_from([*STANDARD_VIEWS, HERO_VIEW]))
def test_the_camera_fits_the_box_exactly(size: tuple[float, float, float], view: View) -> None:
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


CORNERS = np.zeros((64, 64, 3))
CORNERS[:32, :32] = (220, 0, 0)  # top left of the file
CORNERS[:32, 32:] = (0, 220, 0)
CORNERS[32:, :32] = (0, 0, 220)
CORNERS[32:, 32:] = (220, 220, 0)
PLACES = {"top left": (0.0, -0.5, 1.5), "top right": (0.0, 0.5, 1.5), "bottom left": (0.0, -0.5, 0.5)}


def textured(use: TextureUse) -> Model:
    return model(
        upright(),
        materials=(Material("print", base_color=(1, 1, 1), base_color_texture=use, roughness=1.0),),
        textures=(image("corners", CORNERS),),
    )


@pytest.mark.parametrize(
    ("use", "channels"),
    [
        (TextureUse("corners"), {"top left": 0, "top right": 1, "bottom left": 2}),
        # Moving the coordinates by half an image puts the right half to the left; clamped, the right edge fills all.
        (TextureUse("corners", uv_offset=(0.5, 0.0)), {"top left": 1, "top right": 0}),
        (TextureUse("corners", uv_offset=(0.5, 0.0), wrap_s="clamp"), {"top left": 1, "top right": 1}),
        (TextureUse("corners", uv_offset=(0.5, 0.0), wrap_s="mirror"), {"top left": 1, "top right": 1}),
        # Scale first, then turn: (u, v) -> (-v, u) samples the image a quarter turn on.
        (TextureUse("corners", uv_rotation_rad=np.pi / 2), {"bottom left": None, "top left": 2, "top right": 0}),
    ],
    ids=["plain", "offset", "clamp", "mirror", "rotated"],
)
def test_textures_lie_where_their_coordinates_say(
    use: TextureUse, channels: dict[str, int | None], tmp_path: Path
) -> None:
    content = textured(use)
    picture = pictures(content, tmp_path)["view_front"]
    for place, channel in channels.items():
        color = at(picture, content, FRONT, PLACES[place])
        if channel is None:  # the yellow quarter
            assert min(color[:2]) > color[2] + 100
        else:
            assert color[channel] > np.delete(color, channel).max() + 100


def test_alpha_modes(tmp_path: Path) -> None:
    alpha = np.zeros((8, 8, 4))
    alpha[..., :3], alpha[:4, :, 3], alpha[4:, :, 3] = 255, 255, 100  # upper half solid, lower half 0.39
    use, hole = TextureUse("alpha"), TextureUse("alpha", channel="a")
    front = Material("front", base_color=(0.05, 0.6, 0.05), base_color_texture=use, opacity_texture=hole, roughness=1.0)
    back = Material("back", base_color=RED, roughness=1.0)
    upper, lower = (0.2, 0.0, 1.5), (0.2, 0.0, 0.5)
    colors = {}
    for mode in ("opaque", "mask", "blend"):
        content = model(
            upright(x=0.2),
            upright(x=-0.2, material=1),
            materials=(dataclasses.replace(front, alpha_mode=mode), back),
            textures=(image("alpha", alpha),),
        )
        picture = pictures(content, tmp_path / mode)["view_front"]
        colors[mode] = at(picture, content, FRONT, upper), at(picture, content, FRONT, lower)
        assert colors[mode][0][1] > colors[mode][0][0] + 60, mode
    assert colors["opaque"][1][1] > colors["opaque"][1][0] + 60
    assert colors["mask"][1][0] > colors["mask"][1][1] + 60
    mixed = 100 / 255 * colors["opaque"][1] + 155 / 255 * colors["mask"][1]
    assert colors["blend"][1] == pytest.approx(mixed, abs=14)


def test_sheets_are_lit_from_both_sides_and_without_normals(tmp_path: Path) -> None:
    content = model(upright(), materials=(Material("red", base_color=RED),))
    turned = model(dataclasses.replace(content.meshes[0], triangles=QUAD[:, ::-1].copy()), materials=content.materials)
    seen, other = pictures(content, tmp_path), pictures(turned, tmp_path)
    middle = (0.0, 0.0, 1.0)
    front, back = at(seen["view_front"], content, FRONT, middle), at(seen["view_back"], content, BACK, middle)
    assert front == pytest.approx(back, abs=6)
    assert front[0] > 150
    assert at(other["view_front"], content, FRONT, middle) == pytest.approx(front, abs=6)


def test_normals_against_the_winding_are_turned(tmp_path: Path) -> None:
    ball = sphere(0.5, 32)
    mesh = Mesh("ball", ball.points, ball.triangles.astype(np.int32), ball.normals.astype(np.float32))
    inward = dataclasses.replace(mesh, normals=-ball.normals.astype(np.float32))
    assert (pictures(model(mesh), tmp_path)["view_left"] == pictures(model(inward), tmp_path)["view_left"]).all()


def test_missing_normals_come_from_the_face(tmp_path: Path) -> None:
    normals = np.zeros((2, 3, 3), dtype=np.float32)
    normals[1] = np.nan
    bare, poor = upright(), dataclasses.replace(upright(), normals=normals)
    red = (Material("red", base_color=RED),)
    first, second = pictures(model(bare, materials=red), tmp_path), pictures(model(poor, materials=red), tmp_path)
    assert all((first[name] == second[name]).all() for name in first)


@pytest.mark.parametrize("mirrored", [False, True])
def test_normal_maps_shade_like_tilted_normals(mirrored: bool, tmp_path: Path) -> None:
    uvs = UNIT_UVS * np.array([-1, 1], dtype=np.float32) if mirrored else UNIT_UVS
    texel = np.array([60, 170, 235])
    bumpy = Material("m", normal_texture=TextureUse("bump"), roughness=1.0)
    textures = (image("bump", np.tile(texel, (4, 4, 1))),)
    mapped = pictures(model(upright(uvs), materials=(bumpy,), textures=textures), tmp_path)
    u, v, out = texel / 255.0 * 2.0 - 1.0
    tilted = np.array([out, -u if mirrored else u, v]) / np.linalg.norm([u, v, out])  # sheet: +y is u, +z is v
    mesh = dataclasses.replace(upright(), normals=np.tile(tilted.astype(np.float32), (2, 3, 1)))
    expected = pictures(model(mesh, materials=(Material("m", roughness=1.0),)), tmp_path)
    flat = pictures(model(upright(), materials=(Material("m", roughness=1.0),)), tmp_path)
    assert max(np.abs(mapped[name] - expected[name]).max() for name in flat) <= 3
    assert max(np.abs(mapped[name] - flat[name]).max() for name in flat) >= 12


def test_scalar_inputs_read_their_channel(tmp_path: Path) -> None:
    packed = (image("orm", np.full((4, 4, 3), (255, 64, 255))),)
    scalar = Material("m", base_color=RED, metallic=1.0, roughness=64 / 255)
    mapped = dataclasses.replace(
        scalar, roughness=1.0, metallic_texture=TextureUse("orm", "b"), roughness_texture=TextureUse("orm", "g")
    )
    first = pictures(model(upright(), materials=(mapped,), textures=packed), tmp_path)["view_top"]
    second = pictures(model(upright(), materials=(scalar,)), tmp_path)["view_top"]
    assert np.abs(first - second).max() <= 2


def test_vertex_colors_and_light_of_its_own(tmp_path: Path) -> None:
    colors = np.tile(np.array([0.0, 0.0, 0.6, 1.0], dtype=np.float32), (2, 3, 1))
    blue = dataclasses.replace(upright(), colors=colors)
    lamp = Material("lamp", base_color=(0.0, 0.0, 0.0), emissive=(0.0, 0.5, 0.0))
    content = model(blue, materials=(Material("white", base_color=(1, 1, 1)),))
    assert np.argmax(at(pictures(content, tmp_path)["view_front"], content, FRONT, (0, 0, 1))) == 2
    content = model(upright(), materials=(lamp,))
    green = linear(at(pictures(content, tmp_path)["view_front"], content, FRONT, (0, 0, 1)))
    assert green[1] - green[0] == pytest.approx(0.5, abs=0.05)


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
        arrays.save(request, RenderRequest, tmp_path / f"{name}.npz")
        command = [sys.executable, "-m", "render", str(tmp_path / f"{name}.npz")]
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
    arrays.save(RenderRequest(model(upright()), (), str(tmp_path)), RenderRequest, tmp_path / "r.npz")
    monkeypatch.setattr(window, "_loads", lambda library: False)
    written = io.StringIO()
    monkeypatch.setattr(sys, "stderr", written)
    assert main([str(tmp_path / "absent.npz")]) == 2
    arrays.save(RenderRequest(model(), (), str(tmp_path)), RenderRequest, tmp_path / "r.npz")
    assert main([str(tmp_path / "r.npz")]) == NO_OPENGL
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
