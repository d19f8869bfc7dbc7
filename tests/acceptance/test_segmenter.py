"""`mana assets ingest --segmenter`: a program of the user's own proposes parts; what it breaks is told."""

from __future__ import annotations

import json
import sys
import textwrap
from pathlib import Path

import pytest
import trimesh
from typer.testing import CliRunner

from assetkit.parts.segmenter import MODEL_TRUST
from cli.main import app

GOOD = """
    import json, sys
    from pathlib import Path
    import numpy as np
    surface = np.load(sys.argv[1])
    asked = json.loads(Path(sys.argv[1]).with_name("question.json").read_text())
    middles = surface["points"][surface["triangles"]].mean(axis=1)
    upper = np.flatnonzero(middles[:, 2] > 0.1).tolist()
    parts = [{"label": label, "confidence": 0.9, "triangles": upper} for label in ("head", "halo")]
    Path(sys.argv[2]).write_text(json.dumps({"parts": parts if "head" in asked["labels"] else []}))
"""


@pytest.fixture
def figure(tmp_path: Path) -> Path:
    """A body with a head, in one shell."""
    body = trimesh.creation.icosphere(2, 0.06).apply_translation((0.0, 0.0, 0.06))
    head = trimesh.creation.icosphere(2, 0.035).apply_translation((0.0, 0.0, 0.14))
    trimesh.boolean.union([body, head], engine="manifold").export(tmp_path / "thing.stl")
    return tmp_path / "thing.stl"


def ingested(source: Path, *flags: str):
    stated = ["--category", "toy_figure", "--units", "m", "--up-axis", "z", "--jobs", "1", "--json"]
    return CliRunner().invoke(
        app, ["assets", "ingest", str(source), "--out", str(source.parent / "library"), *stated, *flags]
    )


def test_its_regions_become_parts_and_what_was_left_out_is_told(figure: Path) -> None:
    """The next run asks nothing; a changed program is asked again."""
    script = figure.parent / "my segmenter.py"
    script.write_text(textwrap.dedent(GOOD), encoding="utf-8")
    command = f'{sys.executable} "{script}"'
    (item,) = json.loads(ingested(figure, "--segmenter", command).stdout)["items"]
    record = json.loads((figure.parent / "library/thing/record.json").read_text())
    (label,) = [p["value"]["label"] for p in record["parts"] if "learned" in p["value"]["sources"]]
    assert (label["value"], label["inputs"]) == ("head", ["segmenter my segmenter.py"])
    assert label["confidence"] == pytest.approx(MODEL_TRUST * 0.9)
    (told,) = [d["headline"] for d in item["diagnostics"] if d["code"] == "asset/segmenter-failed"]
    assert "1 with a name not asked for" in told
    script.write_text("raise SystemExit('no model here')", encoding="utf-8")
    (item,) = json.loads(ingested(figure, "--segmenter", command).stdout)["items"]
    assert not item["cached"]
    (told,) = [d["headline"] for d in item["diagnostics"] if d["code"] == "asset/segmenter-failed"]
    assert told == "my segmenter.py: failed: no model here"
    assert item["packages"] == ["thing"]


@pytest.mark.parametrize(
    ("flags", "why"),
    [
        (("--segmenter", "no-such-program"), "names no program"),
        (("--segmenter", ""), "names no program"),
        (("--segmenter", "python 'half"), "No closing quotation"),
        (("--segmenter", "python", "--segmenter-timeout", "900"), "below --timeout"),
    ],
)
def test_a_command_that_cannot_run_is_refused_before_anything_is_made(
    figure: Path, flags: tuple[str, ...], why: str
) -> None:
    result = ingested(figure, *flags)
    assert result.exit_code == 2
    assert why in " ".join(result.output.replace("│", " ").split())
    assert not (figure.parent / "library").exists()
