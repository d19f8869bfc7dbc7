"""Parts that a role depends on and clues dispute: they are listed, a person decides, the next run uses the label."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from assetkit.parts.find import find_parts
from assetkit.parts.human_labels import disputed_parts, outdated_regions, region_key, with_human_labels
from cli.main import app
from schemas.appearance.material import Material
from schemas.decision import Decision, PartLabel
from schemas.evidence import Evidence, declared
from schemas.model import Mesh
from schemas.parts import Part

BODY = trimesh.creation.cylinder(0.05, 0.1, sections=24)
COVER = trimesh.creation.cylinder(0.045, 0.01, sections=24).apply_translation((0.0, 0.0, 0.055))


def disputed() -> tuple[Evidence[Part], ...]:
    """Of a pot whose cover is called lid by its node and handle by its material."""
    meshes = {
        name: Mesh(
            name, np.asarray(m.vertices), np.asarray(m.faces, dtype=np.int32), material=i, source_path=f"/{name}"
        )
        for i, (name, m) in enumerate((("body", BODY), ("lid", COVER)))
    }
    return find_parts(meshes, (Material("steel"), Material("handle")), declared("pot", "test")).parts


def called(part: Part, label: str, by: str = "Ann") -> Decision:
    return Decision(
        source="a", source_sha256="b", parts={part.part_id: PartLabel(label=label, region=region_key(part))}, by=by
    )


def test_only_roles_that_depend_on_the_part_ask_a_person() -> None:
    parts = disputed()
    (asked,) = disputed_parts(parts, [declared("receptacle", "test")])
    assert asked.may_be == ("handle", "lid")
    assert disputed_parts(parts, [declared("support", "test")]) == ()
    assert disputed_parts(parts, []) == ()


def test_the_last_decision_about_a_region_stands_and_others_are_left_alone() -> None:
    parts = disputed()
    (asked,) = disputed_parts(parts, [declared("receptacle", "test")])
    decisions = [called(asked, "handle"), called(asked, "lid", "Bob")]
    label = {p.value.part_id: p.value.label for p in with_human_labels(parts, decisions)}[asked.part_id]
    assert (label.value, label.source, label.method) == ("lid", "declared", "decision by Bob")
    assert with_human_labels(parts, [*decisions, called(asked, "")]) == parts
    assert not disputed_parts(with_human_labels(parts, [called(asked, "unlabelled")]), [declared("receptacle", "test")])
    others = [p for p in parts if p.value.part_id != asked.part_id]
    assert [p for p in with_human_labels(parts, decisions) if p.value.part_id != asked.part_id] == others


def test_a_region_that_is_no_part_any_more_is_told() -> None:
    parts = disputed()
    assert outdated_regions(parts, [called(parts[0].value, "lid")]) == ()
    assert outdated_regions(parts[1:], [called(parts[0].value, "lid")]) == (parts[0].value.part_id,)


def obj(folder: Path) -> Path:
    """The same pot as OBJ and MTL."""
    lines, first = ["mtllib pot.mtl"], 1
    for name, material, mesh in (("body", "steel", BODY), ("lid", "handle", COVER)):
        lines += [f"o {name}", f"usemtl {material}", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in mesh.vertices)]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in mesh.faces]
        first += len(mesh.vertices)
    (folder / "pot.mtl").write_text("newmtl steel\nKd 1 0 0\nnewmtl handle\nKd 0 1 0\n")
    (folder / "pot.obj").write_text("\n".join(lines))
    return folder / "pot.obj"


def run(*words: str):
    return CliRunner().invoke(app, ["assets", *words])


def test_a_disputed_lid_is_listed_decided_and_replayed(tmp_path: Path) -> None:
    source, library = obj(tmp_path), str(tmp_path / "library")
    flags = ["--out", library, "--category", "pot", "--units", "m", "--up-axis", "z", "--jobs", "1", "--json"]
    (item,) = json.loads(run("ingest", str(source), *flags).stdout)["items"]
    assert (item["outcome"], "asset/part-disputed" in item["codes"]) == ("review", True)

    (question,) = json.loads(run("review", library, "--json").stdout)
    (doubt,) = [d for d in question["doubts"] if d["flag"] == "part"]
    assert [c["value"] for c in doubt["candidates"]] == ["handle", "lid", "unlabelled"]
    assert any(p.endswith("parts.png") for p in question["pictures"])
    for wrong in ("wing", "part_99=lid", f"{doubt['field']}=wing"):
        assert run("review", library, "pot.obj", "--part", wrong, "--by", "Ann").exit_code == 2
    assert run("review", library, "pot.obj", "--part", f"{doubt['field']}=lid", "--by", "Ann").exit_code == 0

    (item,) = json.loads(run("ingest", str(source), *flags).stdout)["items"]
    assert item["outcome"] != "review"
    assert "asset/part-disputed" not in item["codes"]
    record = json.loads((tmp_path / "library/pot/record.json").read_text())
    labels = {p["value"]["part_id"]: p["value"]["label"] for p in record["parts"]}
    assert labels[doubt["field"]]["method"] == "decision by Ann"
    assert {a["value"]["kind"] for a in record["affordances"]} >= {"lid"}
    shown = run("review", library, "pot.obj").stdout
    assert f"decided by Ann: {doubt['field']}=lid" in shown


@pytest.mark.parametrize("line", [{"parts": {"part_0": "lid"}}, {"parts": {"part_0": {"label": "lid"}}}])
def test_a_part_without_its_region_is_no_decision(line: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="parts"):
        Decision.model_validate({"source": "a", "source_sha256": "b", "by": "Ann", **line})
