"""URDF and MJCF as sources: what links look like, weigh and how they move, the shared truth, and bad files."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.exchange.obj import export_obj

from assetkit.readers.by_format import READERS
from assetkit.sources.source_file import SourceFile
from schemas.diagnostics import InvalidInput
from schemas.model import Model
from schemas.outcome import Outcome
from tests.support.bad_inputs.robot import inertial, joint, link, mjcf, shape, urdf, write
from tests.support.present import present

BOX = shape('<box size="2 1 1"/>')
LIMIT = '<limit lower="{}" upper="{}"/>'


def visual(geometry: str, more: str = "", place: str = "") -> str:
    return f"<visual>{place}<geometry>{geometry}</geometry>{more}</visual>"


def read(path: Path, root: Path | None = None) -> Outcome[Model]:
    return READERS["urdf"](SourceFile(path, root or path.parent))


def model_of(files: dict[str, str], folder: Path) -> Model:
    return present(read(write(files, folder)).value)


def extent(model: Model) -> np.ndarray:
    points = np.concatenate([mesh.points for mesh in model.meshes])
    return np.stack([points.min(axis=0), points.max(axis=0)])


def test_primitives_are_posed_and_belong_to_their_links(tmp_path: Path) -> None:
    turned = '<origin xyz="0 0 3" rpy="0 0 1.5707963267948966"/>'
    files = urdf(link("a", BOX), link("b", BOX), joint("j", "a", "b", "revolute", LIMIT.format(0, 1) + turned))
    model = model_of(files, tmp_path)
    assert [mesh.link for mesh in model.meshes] == ["a", "b"]
    assert extent(model) == pytest.approx(np.array([[-1, -1, -0.5], [1, 1, 3.5]]))
    assert (model.meters_per_unit.value, model.up_axis.value) == (1.0, "z")


def test_what_is_drawn_hides_what_only_collides(tmp_path: Path) -> None:
    ball = visual('<sphere radius="1"/>')
    assert extent(model_of(urdf(link("a", BOX + ball)), tmp_path))[1] == pytest.approx([1, 1, 1])
    geoms = '<geom type="sphere" size="1" contype="0" conaffinity="0"/><geom type="box" size="3 3 3"/>'
    assert extent(model_of(mjcf(f"<body>{geoms}</body>\n"), tmp_path))[1] == pytest.approx([1, 1, 1])
    empty = visual('<sphere radius="0"/>')
    assert extent(model_of(urdf(link("a", BOX + empty)), tmp_path))[1] == pytest.approx([1, 0.5, 0.5])


def test_a_mirrored_mesh_keeps_its_outside_outside(tmp_path: Path) -> None:
    cone = trimesh.creation.cone(1.0, 2.0)
    (tmp_path / "cone.obj").write_text(export_obj(cone))
    plain, mirrored = (
        model_of(urdf(link("a", visual(f'<mesh filename="cone.obj" scale="{s}"/>'))), tmp_path).meshes[0]
        for s in ("1 1 1", "1 -1 1")
    )
    volumes = [float(np.linalg.det(mesh.points[mesh.triangles]).sum() / 6.0) for mesh in (plain, mirrored)]
    assert volumes[0] > 0.0
    assert volumes[1] == pytest.approx(volumes[0])


def test_stated_colours_replace_none_and_masses_are_those_of_the_whole_link(tmp_path: Path) -> None:
    red = '<material name="red"><color rgba="1 0 0 0.5"/></material>'
    body = link("a", visual('<box size="1 1 1"/>', red) + inertial(2.0))
    lid = link("b", BOX + inertial(1.0))
    model = model_of(urdf(body, lid, joint("j", "a", "b", "fixed", '<origin xyz="3 0 0"/>')), tmp_path)
    (material,) = model.materials
    assert (material.name, material.base_color, material.opacity) == ("red", pytest.approx((1, 0, 0)), 0.5)
    (stated,) = model.masses
    assert stated.mass_kg == pytest.approx(3.0)
    assert present(stated.centre) == pytest.approx([1, 0, 0])
    assert stated.triangles == model.triangle_count


def test_the_default_density_of_mujoco_states_nothing(tmp_path: Path) -> None:
    assert not model_of(mjcf('<body><geom type="box" size="1 1 1"/></body>\n'), tmp_path).masses
    (stated,) = model_of(mjcf('<body><geom type="box" size="1 1 1" mass="3"/></body>\n'), tmp_path).masses
    assert stated.mass_kg == pytest.approx(3.0)


def test_files_of_mujoco_s_own_format_are_read_and_damaged_ones_refused(tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 2, 3))
    counts = np.array([8, 0, 0, 12], dtype="<i4").tobytes()
    data = counts + box.vertices.astype("<f4").tobytes() + box.faces.astype("<i4").tobytes()
    (tmp_path / "box.msh").write_bytes(data)
    files = mjcf('<geom type="mesh" mesh="box"/>\n', '<asset><mesh file="box.msh" scale="1 1 2"/></asset>\n')
    assert np.ptp(extent(model_of(files, tmp_path)), axis=0) == pytest.approx([1, 2, 6])
    for damaged, code in (
        (data[:-4], "asset/truncated"),
        (data[:-4] + b"\xff\x00\x00\x00", "asset/index-out-of-range"),
    ):
        (tmp_path / "box.msh").write_bytes(damaged)
        with pytest.raises(InvalidInput) as refused:
            read(write(files, tmp_path))
        assert refused.value.diagnostic.code == code


TWO = link("a", BOX) + link("b", BOX)
CHAIN = [link(f"l{i}", BOX) for i in range(10_000)] + [joint(f"j{i}", f"l{i}", f"l{i + 1}") for i in range(9_999)]


@pytest.mark.parametrize(
    ("code", "files"),
    [
        ("robot/invalid-number", urdf(TWO, joint("j", "a", "b", "revolute", LIMIT.format("nan", 1)))),
        ("robot/zero-axis", urdf(TWO, joint("j", "a", "b", inside='<axis xyz="0 0 0"/>'))),
        ("robot/missing-link", urdf(TWO, joint("j", "a", "c"))),
        ("robot/link-cycle", urdf(TWO, joint("i", "a", "b"), joint("j", "b", "a"))),
        ("robot/several-roots", urdf(TWO)),
        ("robot/path-escape", urdf(link("a", visual('<mesh filename="../../hand.obj"/>')))),
        ("robot/missing-mesh", urdf(link("a", visual('<mesh filename="hand.obj"/>')))),
        ("asset/empty-geometry", urdf(link("a"))),
        ("asset/format-unsupported", {**urdf(link("a", visual('<mesh filename="a.3ds"/>'))), "a.3ds": ""}),
        ("robot/unsupported-shape", mjcf('<body><composite type="grid"/><geom size="1"/></body>\n')),
        ("robot/too-many-links", urdf(*CHAIN)),
    ],
)
def test_bad_files_end_with_a_code(code: str, files: dict[str, str], tmp_path: Path) -> None:
    with pytest.raises(InvalidInput) as refused:
        read(write(files, tmp_path))
    assert refused.value.diagnostic.code == code
    assert refused.value.diagnostic.where.file


def test_all_files_that_a_description_is_made_of_count_as_read(tmp_path: Path) -> None:
    (tmp_path / "box.obj").write_text(export_obj(trimesh.creation.box()))
    included = {"part.xml": '<mujoco><worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>'}
    before = '<include file="part.xml"/><asset><mesh name="m" file="box.obj"/></asset>'
    source = SourceFile(write(mjcf("", before, **included), tmp_path), tmp_path)
    READERS["mjcf"](source)
    assert {file.path for file in source.files_read()} == {"model.xml", "part.xml", "box.obj"}


# The joints of the shared files, as their owners listed them.

BASE_JOINTS = {  # between the world and the object: reported, not carried over
    "pb_half_cheetah_mjcf": {"ignorex", "ignorez", "ignorey"},
    "gen_mjcf_degrees": {"h"},
}
WORDS = {"hinge": "revolute", "slide": "prismatic"}


def truth_of(entry: str | list[dict]) -> dict[str, tuple[str, tuple[float, float] | None]]:
    """Kind and limits by the name of the joint; fixed ones left out."""
    if isinstance(entry, str):
        rows = [row.strip().split(":") for row in entry.split("|")]
        spans = [re.findall(r"-?[\d.]*\d", row[2].replace("..", " ")) if len(row) > 2 else [] for row in rows]
        return {
            row[0]: (row[1].split()[0], (float(s[0]), float(s[1])) if s else None)
            for row, s in zip(rows, spans, strict=True)
        }
    joints: dict[str, tuple[str, tuple[float, float] | None]] = {}
    for row in entry:
        kind = row["type"].removeprefix("Physics").removesuffix("Joint").lower()
        limits = row.get("range") or [row.get("lower"), row.get("upper")]
        if "lowerLimit" in row:
            limits = [row["lowerLimit"], row["upperLimit"]]
            limits = np.radians(limits).tolist() if kind == "revolute" else limits
        if kind != "fixed":
            span = tuple(float(v) for v in limits if v is not None and np.isfinite(float(v)))
            joints[row["name"]] = (
                WORDS.get(kind, kind),
                (span[0], span[1]) if len(span) == 2 and kind != "continuous" else None,
            )
    return joints


@pytest.mark.shared
def test_joints_of_the_shared_files_are_those_of_the_list(shared_assets: Path) -> None:
    listed = json.loads((shared_assets / "joints.json").read_text())
    with (shared_assets / "manifest.csv").open() as file:
        rows = {row["id"]: row for row in csv.DictReader(file)}
    compared = 0
    for name, entry in listed.items():
        row = rows[name]
        if row["outcome"] == "reject" or row["format"] not in ("urdf", "mjcf", "usd"):
            continue
        path = shared_assets / row["path"]
        root = shared_assets.joinpath(*Path(row["path"]).parts[: 3 if "malformed" in row["path"] else 2])
        mechanism = present(READERS[row["format"]](SourceFile(path, root)).value).mechanism
        ours = {j.source_name: j for j in mechanism.joints} if mechanism is not None else {}
        truth = {k: v for k, v in truth_of(entry).items() if k not in BASE_JOINTS.get(name, ())}
        assert ours.keys() == truth.keys(), name
        for key, (kind, limits) in truth.items():
            stated = ours[key].limits if not ours[key].limits_inferred else None
            endless = "continuous" if kind == "revolute" and limits is None else kind
            assert ours[key].kind in (kind, endless), (name, key)
            assert (stated is None) == (limits is None), (name, key, stated, limits)
            assert stated is None or stated == pytest.approx(limits, abs=1e-3), (name, key)
            compared += 1
    assert compared > 80
