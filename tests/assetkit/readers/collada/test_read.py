"""The COLLADA reader: primitives, transforms, materials, broken values, hostile XML."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from assetkit.readers.collada.read import read_dae
from assetkit.sources.source_file import SourceFile
from geom.mesh.polygon_triangulation import triangulate_with_holes
from schemas.diagnostics import InvalidInput
from schemas.model import Model
from schemas.outcome import Outcome

ASSETS = Path(__file__).parents[4].parent / "shared" / "data" / "assets"
POINTS = "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1"
QUADS = "3 2 1 0 4 5 6 7 0 1 5 4 1 2 6 5 2 3 7 6 3 0 4 7"
EFFECT = "<phong><diffuse><color>1 0.5 0 1</color></diffuse></phong>"
NODE = '<node id="n" name="n">{transform}{instance}</node>'
INSTANCE = """<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s" target="#m">
<bind_vertex_input semantic="UV" input_semantic="TEXCOORD" input_set="1"/></instance_material></technique_common>
</bind_material></instance_geometry>"""


def primitive(
    kind: str = "polylist", inner: str = f"<vcount>4 4 4 4 4 4</vcount><p>{QUADS}</p>", more: str = ""
) -> str:
    return f"""<{kind} count="6" material="s"><input semantic="VERTEX" source="#v" offset="0"/>{more}{inner}</{kind}>"""


def dae(
    *,
    asset: str = '<asset><unit meter="0.01" name="centimeter"/><up_axis>Z_UP</up_axis></asset>',
    points: str = POINTS,
    surface: str = primitive(),
    sources: str = "",
    effect: str = EFFECT,
    nodes: str = NODE.format(transform="", instance=INSTANCE),
    more: str = "",
) -> str:
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
{asset}{more}<library_materials><material id="m" name="orange"><instance_effect url="#e"/></material>
</library_materials><library_effects><effect id="e"><profile_COMMON>
<technique sid="c">{effect}</technique></profile_COMMON></effect></library_effects>
<library_geometries><geometry id="g" name="cube"><mesh>
<source id="p"><float_array id="pa" count="24">{points}</float_array><technique_common>
<accessor source="#pa" count="8" stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor>
</technique_common></source>{sources}
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{surface}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="vs">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene></COLLADA>"""


def read(folder: Path, content: str | bytes) -> Outcome[Model]:
    path = folder / "part.dae"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_dae(SourceFile(path, folder))


def model(folder: Path, content: str | bytes) -> Model:
    value = read(folder, content).value
    assert value is not None
    return value


def volume(m: Model) -> float:
    t = np.concatenate([mesh.points[mesh.triangles] for mesh in m.meshes])
    return float(np.einsum("ij,ij->i", t[:, 0], np.cross(t[:, 1], t[:, 2])).sum() / 6)


TRIANGLES = " ".join(f"{a} {b} {c} {a} {c} {d}" for a, b, c, d in np.array(QUADS.split()).reshape(-1, 4))
FANS = "".join(f"<p>{' '.join(q)}</p>" for q in np.array(QUADS.split()).reshape(-1, 4))
STRIPS = "".join(f"<p>{a} {b} {d} {c}</p>" for a, b, c, d in np.array(QUADS.split()).reshape(-1, 4))


@pytest.mark.parametrize(
    "content",
    [
        dae(),
        "\ufeff" + dae(),
        dae().encode("utf-16"),
        dae(surface=primitive("triangles", f"<p>{TRIANGLES}</p>")),
        dae(surface=primitive("polygons", FANS)),
        dae(surface=primitive("trifans", FANS)),
        dae(surface=primitive("tristrips", STRIPS)),
        dae(points=POINTS.replace("1", "1,0")),
        dae(nodes=""),
        dae(nodes='<node><instance_light url="#none"/></node>'),
        dae(nodes=NODE.format(transform="", instance='<instance_geometry url="#g"/>')),
        dae().replace("2005/11", "2008/03"),
    ],
)
def test_every_spelling_of_the_cube_has_its_volume(tmp_path: Path, content: str | bytes) -> None:
    m = model(tmp_path, content.replace('<?xml version="1.0"?>', "") if isinstance(content, str) else content)
    assert m.triangle_count == 12
    assert volume(m) == pytest.approx(1.0)
    assert (m.meters_per_unit.value, m.up_axis.value) == (0.01, "z")


@pytest.mark.parametrize(
    ("transform", "det", "corner"),
    [
        ("<scale>-2 1 1</scale>", 2.0, (-2, 1, 1)),
        ("<translate>5 0 0</translate><rotate>0 0 1 90</rotate>", 1.0, (4, 1, 1)),
        ("<matrix>1 0 0 7 0 -1 0 0 0 0 3 0 0 0 0 1</matrix>", 3.0, (8, -1, 3)),
        ("<lookat>0 0 0 0 0 -1 0 1 0</lookat>", 1.0, (1, 1, 1)),
        ("<skew>45 0 1 0 1 0 0</skew>", 1.0, (2, 1, 1)),
        ("<translate/>", 1.0, (1, 1, 1)),
    ],
)
def test_transforms_apply_in_order_and_mirrors_keep_the_outside(
    tmp_path: Path, transform: str, det: float, corner: tuple[int, int, int]
) -> None:
    m = model(tmp_path, dae(nodes=NODE.format(transform=transform, instance=INSTANCE)))
    assert volume(m) == pytest.approx(det)
    mesh = m.meshes[0]
    assert np.isclose(mesh.points, corner).all(axis=1).any()
    np.testing.assert_allclose(m.nodes[0].X_PN[3], [0, 0, 0, 1])


def test_normals_turn_with_the_surface(tmp_path: Path) -> None:
    source = """<source id="nn"><float_array id="na">0 0 -1 0 0 1 0 -1 0 1 0 0 0 1 0 -1 0 0</float_array>
    <technique_common><accessor source="#na" count="6" stride="3">
    <param name="X"/><param name="Y"/><param name="Z"/></accessor>
    </technique_common></source>"""
    corners = " ".join(f"{c} {i // 4}" for i, c in enumerate(QUADS.split()))
    surface = primitive(
        inner=f"<vcount>4 4 4 4 4 4</vcount><p>{corners}</p>", more='<input semantic="NORMAL" source="#nn" offset="1"/>'
    )
    transform = "<rotate>1 2 3 40</rotate><scale>-2 1 0.5</scale>"
    m = model(tmp_path, dae(sources=source, surface=surface, nodes=NODE.format(transform=transform, instance=INSTANCE)))
    mesh = m.meshes[0]
    t = mesh.points[mesh.triangles]
    facing = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals, np.repeat(facing[:, None], 3, axis=1), atol=1e-6)


def test_instances_library_nodes_and_skins_are_placed(tmp_path: Path) -> None:
    more = """<library_nodes><node id="shared"><translate>10 0 0</translate><instance_geometry url="#g"/></node>
    </library_nodes><library_controllers><controller id="c"><skin source="#g">
    <bind_shape_matrix>1 0 0 0 0 1 0 20 0 0 1 0 0 0 0 1</bind_shape_matrix></skin></controller></library_controllers>"""
    nodes = """<node name="a"><instance_node url="#shared"/></node>
    <node name="b"><scale>2 2 2</scale><instance_node url="#shared"/></node>
    <node name="c"><instance_controller url="#c"/></node>"""
    m = model(tmp_path, dae(more=more, nodes=nodes))
    assert [mesh.points.min(axis=0).tolist() for mesh in m.meshes] == [[10, 0, 0], [20, 0, 0], [0, 20, 0]]
    assert [mesh.source_path for mesh in m.meshes] == ["/a/shared", "/b/shared", "/c"]
    assert [n.path for n in m.nodes if n.meshes] == ["/a/shared", "/b/shared", "/c"]


def test_polygons_with_holes_keep_the_hole_open(tmp_path: Path) -> None:
    outline = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], dtype=float)
    hole = np.array([[1, 1, 0], [2, 1, 0], [2, 2, 0], [1, 2, 0]], dtype=float)
    for rings in ([outline, hole], [outline, hole[::-1]], [outline[::-1], hole]):
        t = np.concatenate(rings)[triangulate_with_holes(rings)]
        area = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])[:, 2] / 2
        assert abs(area.sum()) == pytest.approx(15.0)
        assert (area > 0).all() == (rings[0] is outline)
    points = " ".join(f"{c:g}" for c in np.concatenate([outline, hole]).ravel())
    surface = primitive("polygons", "<ph><p>0 1 2 3</p><h>4 5 6 7</h></ph>")
    assert model(tmp_path, dae(points=points, surface=surface)).triangle_count == 8


def test_materials_follow_symbols_textures_and_uv_sets(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2), (1, 2, 3)).save(tmp_path / "a b.png")
    effect = """<blinn><emission><color>0 0 0 1</color></emission>
    <diffuse><texture texture="smp" texcoord="UV"/></diffuse>
    <specular><color>1 1 1 1</color></specular><shininess><float>6</float></shininess>
    <transparent opaque="RGB_ZERO"><color>0.5 0.5 0.5 1</color></transparent><transparency><float>0.5</float>
    </transparency><index_of_refraction><float>1.4</float></index_of_refraction></blinn>"""
    images = '<library_images><image id="i"><init_from>./a%20b.png</init_from></image></library_images>'
    uv = "".join(
        f'<source id="t{s}"><float_array id="ta{s}">{x} 0 1 0 1 1</float_array><technique_common><accessor source='
        f'"#ta{s}" count="3" stride="2"><param name="S"/><param name="T"/></accessor></technique_common></source>'
        for s, x in ((0, 0.1), (1, 0.2))
    )
    surface = primitive(
        "triangles",
        "<p>0 0 1 1 2 2</p>",
        '<input semantic="TEXCOORD" source="#t1" offset="1" set="1"/>'
        '<input semantic="TEXCOORD" source="#t0" offset="1" set="0"/>',
    )
    text = dae(effect=effect, more=images, sources=uv, surface=surface).replace(
        "<technique sid",
        """<newparam sid="srf"><surface type="2D"><init_from>i</init_from></surface></newparam>
        <newparam sid="smp"><sampler2D><source>srf</source><wrap_s>CLAMP</wrap_s></sampler2D></newparam>
        <technique sid""",
    )
    m = model(tmp_path, text)
    material = m.materials[0]
    assert material.name == "orange"
    assert material.base_color_texture is not None
    assert (material.base_color_texture.texture, material.base_color_texture.uv_set) == ("a b", 1)
    assert (material.base_color_texture.wrap_s, material.base_color_texture.wrap_t) == ("clamp", "repeat")
    assert material.roughness == pytest.approx((2 / 8) ** 0.25)
    assert (material.opacity, material.alpha_mode, material.ior) == (pytest.approx(0.75), "blend", 1.4)
    assert [round(float(u[0, 0, 0]), 3) for u in m.meshes[0].uvs] == [0.1, 0.2]


@pytest.mark.parametrize(
    ("change", "repairs"),
    [
        ({"asset": '<asset><unit meter="0,01"/></asset>'}, ["invalid_unit_value"]),
        (
            {"effect": EFFECT.replace("</phong>", "<shininess><float>x</float></shininess></phong>")},
            ["invalid_material_value"],
        ),
        (
            {"effect": EFFECT.replace("</phong>", "<shininess><color>0</color></shininess></phong>")},
            ["invalid_material_value"],
        ),
        ({"effect": '<phong><diffuse><texture texture="gone"/></diffuse></phong>'}, ["missing_texture"]),
        ({"surface": primitive() + primitive(inner="<vcount>3</vcount>")}, ["primitive_dropped"]),
        ({"surface": primitive() + primitive("triangles", "<p>0 1 one</p>")}, ["primitive_dropped"]),
        ({"surface": primitive(inner=f"<vcount>4 4 4 4 4 4 4</vcount><p>{QUADS}</p>")}, ["primitive_dropped"]),
        ({"surface": primitive(inner=f"<vcount>4 4 4 4 4 4 2</vcount><p>{QUADS} 1 2</p>")}, ["empty_face_record"]),
    ],
)
def test_small_faults_are_repaired_and_said(tmp_path: Path, change: dict[str, str], repairs: list[str]) -> None:
    outcome = read(tmp_path, dae(**change))
    assert outcome.value is not None
    assert outcome.value.triangle_count == 12
    assert [r.name for r in outcome.repairs] == repairs
    assert all(d.where.line is not None for d in outcome.diagnostics)


def test_animation_is_said_to_be_dropped(tmp_path: Path) -> None:
    more = '<library_animations><animation><channel source="#s" target="n/x"/></animation></library_animations>'
    assert [d.code for d in read(tmp_path, dae(more=more)).diagnostics] == ["asset/animation-dropped"]


def test_legacy_windows_texture_paths_are_absent_not_opened(tmp_path: Path) -> None:
    images = r'<library_images><image id="i"><init_from>file://..\LWO\x.jpg</init_from></image></library_images>'
    effect = '<lambert><diffuse><texture texture="i" texcoord="C"/></diffuse></lambert>'
    outcome = read(tmp_path, dae(more=images, effect=effect))
    assert [r.name for r in outcome.repairs] == ["missing_texture"]


def test_the_standards_defaults_hold_where_the_file_is_silent(tmp_path: Path) -> None:
    m = model(tmp_path, dae(asset="<asset><unit/></asset>"))
    assert (m.meters_per_unit.value, m.meters_per_unit.source, m.up_axis.value) == (1.0, "declared", "y")
    assert m.meters_per_unit.confidence < 1.0


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (dae().replace("<COLLADA", '<!DOCTYPE x [<!ENTITY a "lol">]><COLLADA'), "asset/resource-limit"),
        (
            dae().replace("<COLLADA", '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><COLLADA'),
            "asset/path-escape",
        ),
        (
            dae().replace("<COLLADA", '<!DOCTYPE x [<!ENTITY a "lol">]><COLLADA').encode("utf-16-le"),
            "asset/resource-limit",
        ),
        (b'<?xml version="1.0" encoding="UTF-7"?>+ADw-COLLADA/+AD4-', "asset/parse-error"),
        (dae()[:-12], "asset/parse-error"),
        ("<robot/>", "asset/wrong-content"),
        ("<html><body/></html>", "asset/wrong-content"),
        ("", "asset/empty-geometry"),
        (dae(points=""), "asset/index-out-of-range"),
        (dae(points="", surface=""), "asset/empty-geometry"),
        (dae(surface=""), "asset/no-faces"),
        (dae(surface=primitive("lines", "<p>0 1</p>")), "asset/no-faces"),
        (dae(points=POINTS.replace("1", "NaN", 1)), "asset/nonfinite-vertices"),
        (dae(points=POINTS.replace("1", "one", 1)), "asset/parse-error"),
        (dae(asset='<asset><unit meter="0"/></asset>'), "asset/invalid-unit-value"),
        (dae(asset='<asset><unit meter="big"/></asset>'), "asset/invalid-unit-value"),
        (dae(nodes=NODE.format(transform="<matrix>1 2</matrix>", instance=INSTANCE)), "asset/parse-error"),
        (dae(nodes='<node id="a"><instance_node url="#a"/></node>'), "asset/cyclic-reference"),
        (dae(nodes='<node><instance_node url="other.dae#a"/></node>'), "asset/missing-dependency"),
        (
            dae(
                more='<library_images><image id="i"><init_from>../../x.png</init_from></image></library_images>',
                effect='<phong><diffuse><texture texture="i"/></diffuse></phong>',
            ),
            "asset/path-escape",
        ),
    ],
)
def test_bad_files_are_rejected(tmp_path: Path, content: str | bytes, code: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        read(tmp_path, content)
    assert caught.value.diagnostic.code == code


def test_nodes_that_multiply_without_bound_are_stopped(tmp_path: Path) -> None:
    levels = [f'<node id="b{i}">' + f'<instance_node url="#b{i - 1}"/>' * 10 + "</node>" for i in range(1, 9)]
    more = '<node id="b0"/>' + "".join(levels)
    with pytest.raises(InvalidInput) as caught:
        read(
            tmp_path,
            dae(more=f"<library_nodes>{more}</library_nodes>", nodes='<node><instance_node url="#b8"/></node>'),
        )
    assert caught.value.diagnostic.code == "asset/resource-limit"


@settings(max_examples=300, deadline=None)
@given(st.integers(0, len(dae())), st.integers(0, 60), st.text("<>/=\"'#0123456789,.-eNan xyz&", max_size=6))
def test_mutated_text_never_crashes(tmp_path_factory: pytest.TempPathFactory, at: int, cut: int, extra: str) -> None:
    text = dae()
    try:
        m = model(tmp_path_factory.mktemp("fuzz"), text[:at] + extra + text[at + cut :])
    except InvalidInput:
        return
    assert all(np.isfinite(mesh.points).all() and mesh.triangles.max() < len(mesh.points) for mesh in m.meshes)


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(["points", "p", "vcount", "matrix", "unit"]), st.text("0123456789,.-eNa \n", max_size=40))
def test_mutated_numbers_never_crash(tmp_path_factory: pytest.TempPathFactory, place: str, text: str) -> None:
    content = {
        "points": lambda: dae(points=text),
        "p": lambda: dae(surface=primitive(inner=f"<vcount>4 4</vcount><p>{text}</p>")),
        "vcount": lambda: dae(surface=primitive(inner=f"<vcount>{text}</vcount><p>{QUADS}</p>")),
        "matrix": lambda: dae(nodes=NODE.format(transform=f"<matrix>{text}</matrix>", instance=INSTANCE)),
        "unit": lambda: dae(asset=f'<asset><unit meter="{text}"/></asset>'),
    }[place]()
    try:
        read(tmp_path_factory.mktemp("fuzz"), content)
    except InvalidInput:
        return


@pytest.mark.shared
@pytest.mark.skipif(not ASSETS.is_dir(), reason="shared data folder is absent")
def test_real_files_agree_with_the_manifest_and_trimesh() -> None:
    with (ASSETS / "manifest.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["format"] == "dae"]
    for row in rows:
        path = ASSETS / row["path"]
        source = SourceFile(path, path.parent)
        if row["outcome"] == "reject":
            with pytest.raises(InvalidInput) as caught:
                read_dae(source)
            assert caught.value.diagnostic.code == "asset/" + row["reason"].replace("_", "-"), row["id"]
            continue
        outcome = read_dae(source)
        m = outcome.value
        assert m is not None
        assert (m.up_axis.value, m.meters_per_unit.value) == (row["up_axis"], float(row["meters_per_unit"])), row["id"]
        assert set(row["reason"].split(";")) - {"", "scale_review"} <= {r.name for r in outcome.repairs}, row["id"]
        if row["measured_faces"]:
            reference = trimesh.load_scene(path, process=False)
            assert m.triangle_count == sum(len(g.faces) for g in reference.geometry.values()), row["id"]
            measured = [float(v) for v in row["measured_extent_native"].split("x")]
            points = np.concatenate([mesh.points for mesh in m.meshes])
            np.testing.assert_allclose(np.ptp(points, axis=0), measured, rtol=1e-5, err_msg=row["id"])


@pytest.mark.parametrize(
    ("more", "severity"),
    [("<lines count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1</p></lines>", "info")],
)
def test_lines_beside_faces_are_left_out_with_a_word(tmp_path: Path, more: str, severity: str) -> None:
    outcome = read(tmp_path, dae(surface=primitive() + more))
    assert ("asset/geometry-left-out", severity) in [(d.code, d.severity) for d in outcome.diagnostics]


def test_a_solid_body_that_is_no_mesh_is_left_out_with_a_word(tmp_path: Path) -> None:
    brep = "<library_geometries><geometry id='b'><convex_mesh/></geometry></library_geometries>"
    nodes = NODE.format(transform="", instance=INSTANCE) + "<node><instance_geometry url='#b'/></node>"
    outcome = read(tmp_path, dae(more=brep, nodes=nodes))
    assert ("asset/geometry-left-out", "warning") in [(d.code, d.severity) for d in outcome.diagnostics]


def test_the_help_for_entities_is_to_remove_them(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as caught:
        read(tmp_path, dae().replace("<COLLADA", '<!DOCTYPE x [<!ENTITY a "lol">]><COLLADA'))
    assert "XML entities must go" in caught.value.diagnostic.help
