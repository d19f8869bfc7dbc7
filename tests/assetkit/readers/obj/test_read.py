"""The OBJ and MTL readers: closed forms, named defects, fuzz, and agreement with trimesh on real files."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from assetkit.readers.obj.mtl import split_options
from assetkit.readers.obj.read import read_obj
from assetkit.sources.source_file import SourceFile
from geom.mesh.polygon_triangulation import triangulate_polygons
from schemas.diagnostics import InvalidInput
from schemas.model import Model
from schemas.outcome import Outcome

ASSETS = Path(__file__).parents[4].parent / "shared" / "data" / "assets"
SQUARE = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n"
CUBE = """# made by hand, units: mm
o box
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""


def read(folder: Path, text: str | bytes, **files: str | bytes) -> Outcome[Model]:
    for name, content in {"part.obj": text, **{k.replace("__", "."): v for k, v in files.items()}}.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_obj(SourceFile(folder / "part.obj", folder))


def model(outcome: Outcome[Model]) -> Model:
    assert outcome.value is not None
    return outcome.value


def rejected(folder: Path, text: str | bytes) -> tuple[str, int | None, int | None]:
    with pytest.raises(InvalidInput) as caught:
        read(folder, text)
    d = caught.value.diagnostic
    return d.code, d.where.line, d.where.column


def codes(outcome: Outcome[Model]) -> list[str]:
    return [d.code for d in outcome.diagnostics]


def area_and_volume(m: Model) -> tuple[float, float]:
    t = np.concatenate([mesh.points[mesh.triangles] for mesh in m.meshes])
    cross = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    return float(np.linalg.norm(cross, axis=1).sum() / 2), float(np.einsum("ij,ij->i", t[:, 0], cross).sum() / 6)


def test_a_cube_of_quads_has_its_area_volume_and_hints(tmp_path: Path) -> None:
    outcome = read(tmp_path, CUBE)
    m = model(outcome)
    assert m.triangle_count == 12
    assert area_and_volume(m) == pytest.approx((6.0, 1.0))
    assert m.hints == ("# made by hand, units: mm",)
    assert (m.meters_per_unit.source, m.meters_per_unit.confidence, m.up_axis.value) == ("default", 0.0, "z")
    assert m.meshes[0].source_path == "/box"
    assert not outcome.diagnostics


@pytest.mark.parametrize(
    "rewrite",
    [
        lambda t: t.replace("\n", "\r\n"),
        lambda t: "\ufeff" + t,
        lambda t: t.replace("f 5 6 7 8", "f 5 6 \\\n  7 8"),
        lambda t: t.replace("f 5 6 7 8", "\tf\t5  6 7 8   # top"),
        lambda t: t.replace("f 4 1 5 8", "f -5 -8 -4 -1"),
        lambda t: t.replace("v 1 1 1", "v +1.0e0 1. 1 1.0"),
        lambda t: t.replace("f 1 2 6 5", "f 1/ 2// 6 5//"),
        lambda t: t + "l 1 2\np 3\ns off\nsome_future_statement 1",
    ],
)
def test_spellings_of_the_same_cube_read_the_same(tmp_path: Path, rewrite) -> None:
    m = model(read(tmp_path, rewrite(CUBE)))
    assert m.triangle_count == 12
    assert area_and_volume(m) == pytest.approx((6.0, 1.0))


def test_relative_indices_count_back_from_their_own_line(tmp_path: Path) -> None:
    m = model(read(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf -3 -2 -1\n"))
    assert sorted(set(m.meshes[0].points[:, 2])) == [0.0, 1.0]


@given(st.lists(st.floats(0.2, 1.0), min_size=5, max_size=12))
def test_star_polygons_keep_their_area_and_winding(radii: list[float]) -> None:
    """A polygon that is star-shaped about the origin has the area of its sectors, however concave it is."""
    k = len(radii)
    angle = 2 * np.pi * np.arange(k) / k
    ring = np.array(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    tilt = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])[:3, :3]
    points = np.c_[ring, np.zeros(k)] @ tilt.T
    expected = 0.5 * np.sin(2 * np.pi / k) * np.sum(np.array(radii) * np.roll(radii, -1))
    triangles, owner = triangulate_polygons(points, np.arange(k), np.array([k]))
    t = points[triangles]
    signed = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]) @ (tilt @ [0, 0, 1]) / 2
    assert len(triangles) == k - 2
    assert set(owner) == {0}
    assert signed.min() > -1e-9
    assert signed.sum() == pytest.approx(expected, rel=1e-6)


def test_a_hole_joined_by_a_bridge_stays_open(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\nf 1 2 3 4 1 5 6 7 8 5\n"
    m = model(read(tmp_path, text))
    assert area_and_volume(m)[0] == pytest.approx(15.0)


def test_groups_and_materials_part_the_mesh_and_keep_order(tmp_path: Path) -> None:
    text = SQUARE + "mtllib look.mtl\ng lid\nusemtl red paint\nf 1 2 3\ng base\nusemtl steel\nf 1 3 4\ng lid\n"
    text += "usemtl red paint\nf 3 4 1\n"
    m = model(read(tmp_path, text, look__mtl="newmtl steel\nPm 1\nPr 0.3\nnewmtl red paint\nKd 1 0 0\n"))
    assert [(mesh.name, mesh.material, len(mesh.triangles)) for mesh in m.meshes] == [("lid", 0, 2), ("base", 1, 1)]
    assert [(x.name, x.metallic, x.roughness) for x in m.materials] == [("red paint", 0.0, 0.5), ("steel", 1.0, 0.3)]
    assert m.materials[0].base_color == (1.0, 0.0, 0.0)


def test_uvs_normals_and_colours_follow_their_corners(tmp_path: Path) -> None:
    text = "v 0 0 0 1 0 0\nv 1 0 0 0 0.5 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 4\nf 1/1/1 2/2/1 3/3/1\n"
    mesh = model(read(tmp_path, text)).meshes[0]
    assert mesh.uvs[0][0].tolist() == [[0, 0], [1, 0], [0, 1]]
    assert mesh.normals is not None
    assert mesh.normals[0].tolist() == [[0, 0, 1]] * 3
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors[0, 1], [0, ((0.5 + 0.055) / 1.055) ** 2.4, 0, 1], rtol=1e-6)
    np.testing.assert_array_equal(mesh.colors[0, 2], [1, 1, 1, 1])


def test_nan_colours_and_zero_normals_are_replaced_and_said(tmp_path: Path) -> None:
    text = "v 0 0 0 nan nan nan\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nvn 0 0 0\nf 1//1 2//1 3//1\n"
    outcome = read(tmp_path, text)
    mesh = model(outcome).meshes[0]
    assert codes(outcome) == ["asset/nonfinite-colors", "asset/bad-normals"]
    assert [r.name for r in outcome.repairs] == ["nan_vertex_color", "bad_normals"]
    assert outcome.diagnostics[0].where.line == 1
    assert mesh.normals is not None
    assert mesh.normals[0].tolist() == [[0, 0, 1]] * 3
    assert mesh.colors is not None
    assert np.isfinite(mesh.colors).all()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("# nothing\n", ("asset/empty-geometry", None, None)),
        ("", ("asset/empty-geometry", None, None)),
        (SQUARE + "l 1 2\n", ("asset/no-faces", None, None)),
        (SQUARE, ("asset/no-faces", None, None)),
        ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", ("asset/nonfinite-vertices", 2, 1)),
        ("v 0 0 0\nv 1 -1.#IND 0\nv 0 1 0\nf 1 2 3\n", ("asset/nonfinite-vertices", 2, 1)),
        ("v 0 0 0\nv 1 x 0\nv 0 1 0\nf 1 2 3\n", ("asset/parse-error", 2, 5)),
        ("v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", ("asset/parse-error", 2, 1)),
        (SQUARE + "f 1 2 3\nf 1 a/b 3\n", ("asset/parse-error", 6, 5)),
        (SQUARE + "f 1 2 9\n", ("asset/index-out-of-range", 5, 1)),
        (SQUARE + "f 0 1 2\n", ("asset/index-out-of-range", 5, 1)),
        (SQUARE + "f -9 1 2\n", ("asset/index-out-of-range", 5, 1)),
        ("hello\nworld\n", ("asset/parse-error", 1, 1)),
        ("<!DOCTYPE html><html>", ("asset/wrong-content", None, None)),
        (b"glTF\x02\x00\x00\x00", ("asset/wrong-content", None, None)),
        (b"v 0 0 0\n\x00\x00", ("asset/wrong-content", None, None)),
        ("version https://git-lfs.github.com/spec/v1\noid sha256:0\n", ("asset/lfs-pointer", None, None)),
        ("mtllib ../secret.mtl\n" + CUBE, ("asset/path-escape", 1, 1)),
        ("mtllib https://example.com/a.mtl\n" + CUBE, ("asset/remote-reference", 1, 1)),
    ],
)
def test_bad_files_are_rejected_with_their_code_and_place(
    tmp_path: Path, text: str | bytes, expected: tuple[str, int | None, int | None]
) -> None:
    assert rejected(tmp_path, text) == expected


def test_a_stray_face_and_a_face_without_corners_are_dropped(tmp_path: Path) -> None:
    outcome = read(tmp_path, CUBE + CUBE.split("1 1\n")[-1] * 2 + "f 1 2 99\nf\n")
    assert model(outcome).triangle_count == 36
    assert sorted(r.name for r in outcome.repairs) == ["empty_face_record", "index_out_of_range"]


def test_material_libraries_may_be_absent_or_several_or_hold_spaces(tmp_path: Path) -> None:
    body = SQUARE + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n"
    assert [r.name for r in read(tmp_path, body).repairs] == []
    assert [r.name for r in read(tmp_path, "mtllib no.mtl\n" + body).repairs] == ["missing_material"]
    files = {"x__mtl": "newmtl a\nd 0.5\n", "y__mtl": "newmtl b\nKe 1 1 1\n", "my look__mtl": "newmtl a\nPc 1\n"}
    m = model(read(tmp_path, "mtllib x.mtl y.mtl\n" + body, **files))
    assert [(x.opacity, x.alpha_mode, x.emissive[0]) for x in m.materials] == [(0.5, "blend", 0), (1, "opaque", 1)]
    outcome = read(tmp_path, "mtllib .\\my look.mtl\n" + body, **files)
    assert model(outcome).materials[0].clearcoat == 1.0
    assert codes(outcome) == ["asset/missing-material"]
    assert "'b'" in outcome.diagnostics[0].headline


def test_mtl_values_textures_and_leftovers(tmp_path: Path) -> None:
    Image.new("RGBA", (4, 4), (9, 9, 9, 128)).save(tmp_path / "my image.png")
    Image.new("RGB", (4, 4), (128, 128, 255)).save(tmp_path / "even.png")
    Image.new("L", (4, 4), 128).save(tmp_path / "height.png")
    mtl = """newmtl a
    Kd 0.5 0.5 0.5
    Ks 1 1 1
    Ns 6
    Ni 1.33
    Tr 0.25
    Ka 1 1 1
    sheen_of_tomorrow 3
    map_Kd -s 2 3 1 -clamp on my image.png
    map_d my image.png
    bump -bm 0.3 even.png
    newmtl b
    Ns shiny
    Kd 0.2
    map_Kd absent.png
    map_Bump height.png
    d 0
    """
    outcome = read(tmp_path, SQUARE + "mtllib m.mtl\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n", m__mtl=mtl)
    a, b = model(outcome).materials
    assert a.roughness == pytest.approx((2 / 8) ** 0.25)
    assert (a.ior, a.opacity, a.alpha_mode) == (1.33, 0.75, "blend")
    assert a.base_color_texture is not None
    assert (a.base_color, a.base_color_texture.uv_scale) == ((1.0, 1.0, 1.0), (2.0, 3.0))
    assert a.base_color_texture.wrap_s == "black"
    assert a.opacity_texture is not None
    assert (a.opacity_texture.texture, a.opacity_texture.channel) == ("my image", "a")
    assert a.normal_texture is not None
    assert a.unmapped["Ka"] == [1.0, 1.0, 1.0]
    assert {"Kd", "Ks", "sheen_of_tomorrow"} <= a.unmapped.keys()
    assert b.base_color[0] == pytest.approx(((0.2 + 0.055) / 1.055) ** 2.4)
    assert (b.normal_texture, b.opacity, b.unmapped["map_Bump"]) == (None, 1.0, "height.png")
    assert sorted(r.name for r in outcome.repairs) == ["invalid_material_value", "missing_texture"]
    bad = next(d for d in outcome.diagnostics if d.headline.startswith("material 'b': Ns"))
    assert (bad.where.file, bad.where.line) == ("m.mtl", 13)


def test_texture_options_end_where_the_file_name_begins() -> None:
    assert split_options("-s 1 2 3 -o 0.5 a b.png") == ({"-s": ["1", "2", "3"], "-o": ["0.5"]}, "a b.png")
    assert split_options("-bm 0.2 3.png") == ({"-bm": ["0.2"]}, "3.png")
    assert split_options("-s") == ({"-s": []}, "")


@settings(max_examples=150, deadline=None)
@given(st.integers(0, len(CUBE) - 1), st.integers(0, 40), st.binary(max_size=6))
def test_mutated_bytes_never_crash(tmp_path_factory: pytest.TempPathFactory, at: int, cut: int, extra: bytes) -> None:
    data = ("mtllib m.mtl\nusemtl a\n" + CUBE).encode()
    mtl = b"newmtl a\nKd 1 0 0\nmap_Kd -s 1 1 1 x.png\nd 1\n"
    folder = tmp_path_factory.mktemp("fuzz")
    try:
        outcome = read(
            folder, data[:at] + extra + data[at + cut :], m__mtl=mtl[: at % 50] + extra + mtl[at % 50 + cut % 9 :]
        )
    except InvalidInput:
        return
    for mesh in model(outcome).meshes:
        assert mesh.triangles.max() < len(mesh.points)
        assert np.isfinite(mesh.points).all()


def rows() -> list[dict[str, str]]:
    if not ASSETS.is_dir():
        return []
    with (ASSETS / "manifest.csv").open() as file:
        return [r for r in csv.DictReader(file) if r["format"] == "obj"]


@pytest.mark.shared
@pytest.mark.skipif(not ASSETS.is_dir(), reason="shared data folder is absent")
def test_real_files_agree_with_the_manifest_and_trimesh() -> None:
    fatal = {"empty_geometry", "no_faces", "wrong_content", "path_escape", "nonfinite_vertices"}
    for row in rows():
        path = ASSETS / row["path"]
        folder = ASSETS.joinpath(*Path(row["path"]).parts[: 3 if row["path"].startswith("malformed") else 2])
        if row["reason"] in fatal:
            with pytest.raises(InvalidInput) as caught:
                read_obj(SourceFile(path, folder))
            assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-"), row["id"]
            continue
        outcome = read_obj(SourceFile(path, folder))
        m = model(outcome)
        reference = trimesh.load_mesh(path, process=False, skip_materials=True)
        points = np.concatenate([mesh.points for mesh in m.meshes])
        np.testing.assert_allclose(np.ptp(points, axis=0), reference.extents, rtol=1e-6, err_msg=row["id"])
        assert m.triangle_count == len(reference.faces), row["id"]
        wanted = set(row["reason"].split(";")) & {
            "missing_texture",
            "missing_material",
            "nan_vertex_color",
            "empty_face_record",
        }
        assert {r.name for r in outcome.repairs} == wanted, row["id"]


@pytest.mark.parametrize(("extra", "severity"), [("l 1 2\n", "info"), ("surf 0 1 0 1 1 2 3 4\n", "warning")])
def test_what_has_no_faces_is_left_out_with_a_word(tmp_path: Path, extra: str, severity: str) -> None:
    outcome = read(tmp_path, SQUARE + "f 1 2 3 4\n" + extra)
    assert [(d.code, d.severity) for d in outcome.diagnostics] == [("asset/geometry-left-out", severity)]


def test_of_several_tiles_the_first_is_shown_and_said(tmp_path: Path) -> None:
    for number in (1001, 1002):
        Image.new("RGB", (2, 2)).save(tmp_path / f"a.{number}.png")
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd a.<UDIM>.png\n")
    outcome = read(tmp_path, "mtllib m.mtl\nusemtl m\n" + SQUARE + "f 1 2 3 4\n")
    assert outcome.value is not None
    assert [t.name for t in outcome.value.textures] == ["a.1001"]
    assert [d.code for d in outcome.diagnostics] == ["asset/unsupported-texture"]


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_is_read_as_utf_8_is_in_mesh_and_materials(tmp_path: Path, encoding: str) -> None:
    def write(name: str, text: str) -> None:
        (tmp_path / name).write_bytes("\ufeff".encode(encoding) + text.encode(encoding))

    write("m.mtl", "newmtl wood\nKd 0.5 0.25 0.125\n")
    write("a.obj", "mtllib m.mtl\nusemtl wood\n" + SQUARE + "f 1 2 3 4\n")
    outcome = read_obj(SourceFile(tmp_path / "a.obj", tmp_path))
    assert outcome.value is not None
    assert (outcome.value.triangle_count, outcome.value.materials[0].name) == (2, "wood")
    assert outcome.value.materials[0].unmapped == read_utf8(tmp_path).materials[0].unmapped


def read_utf8(folder: Path) -> Model:
    """The same files as UTF-8."""
    for path in (folder / "m.mtl", folder / "a.obj"):
        path.write_text(path.read_bytes().decode("utf-16"))
    return model(read_obj(SourceFile(folder / "a.obj", folder)))
