"""Annotation of pictures by a model: what reaches records and report, and what never reaches a file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
import trimesh
from typer.testing import CliRunner

from assetkit.annotate.exchange import KEY_VARIABLE
from assetkit.options import Endpoint, Options
from assetkit.sources.discover import discover
from assetkit.stage import Draft, Semantics, Tools
from assetkit.stages.canonicalize import Canonicalize
from assetkit.stages.intake import ReadSource
from assetkit.stages.semantics import DescribeObject
from cli.main import app
from schemas.asset import AssetRecord
from schemas.outcome import Outcome
from schemas.report import IngestReport, ReportItem
from sim.fake import FakeSimulator
from tests.acceptance.test_pipeline import mana, record_of
from tests.support.bad_inputs.assets import obj_text
from tests.support.endpoint_server import Server, answer, endpoint, openai, says

KEY = "sk-secret-0123456789"
PAD = trimesh.creation.box((0.11, 0.07, 0.015))


def test_an_endpoint_that_fails_and_recovers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(KEY_VARIABLE, KEY)
    out = tmp_path / "out"

    def ingested(server: Server) -> tuple[ReportItem, dict[str, float], AssetRecord]:
        (tmp_path / "part.obj").write_text(obj_text(PAD, "# units: m, z up\n"))
        flags = ("--annotator-url", server.url, "--annotator-model", "looker", "--annotator-price", "2", "10")
        mana("assets", "ingest", tmp_path / "part.obj", "--out", out, "--units", "m", "--up-axis", "z", *flags)
        report = IngestReport.model_validate_json((out / "report.json").read_bytes())
        assert not [f for f in out.rglob("*") if f.is_file() and KEY.encode() in f.read_bytes()]
        return report.items[0], report.totals, record_of(out / "part")

    good = says(openai(answer(sponge=0.9, roles={"tool": 0.9, "distractor": 0.5}, description="A pad.")))
    with endpoint(says("who are you", 401), good) as server:
        item, totals, record = ingested(server)
        assert "asset/annotator-unreachable" in item.codes
        assert record.semantics.category.value == "unknown"
        of_anything = record.physics.mass_kg

        item, totals, record = ingested(server)
        assert server.requests[-1].headers["authorization"] == f"Bearer {KEY}"
        assert "asset/annotator-unreachable" not in item.codes
        category = record.semantics.category
        assert (category.value, category.source, category.method) == ("sponge", "inferred", "looker, prompt 1")
        assert [r.value for r in record.semantics.roles] == ["manipulated", "tool", "distractor"]
        assert record.semantics.endpoint_answer is not None
        assert record.semantics.endpoint_answer.description == "A pad."
        assert record.physics.mass_kg != of_anything  # Later stages came from no store of the run before.
        spent = {name: totals[f"endpoint_{name}"] for name in ("requests", "input_tokens", "output_tokens", "usd")}
        assert spent == {"requests": 1, "input_tokens": 1000, "output_tokens": 50, "usd": 0.0025}
        assert len(server.requests) == 2


def described(server: Server, folder: Path, file: str, *, lost: bool = False, **said) -> Outcome[Semantics]:
    """The outcome of the stage, with pictures drawn and the question sent as in a batch."""
    (folder / file).write_text(obj_text(PAD, "# units: m, z up\n"))
    model = Endpoint(url=server.url, model="looker", seconds=10.0)
    options = Options(units="m", up_axis="z", endpoint=model, **said)
    draft = Draft("part", file, ReadSource().run(discover([folder / file])[0], options).objects[0])
    tools = Tools(FakeSimulator(), folder / "work", options, endpoint_lost=lost)
    return DescribeObject().run(replace(draft, canonicalize=Canonicalize().run(draft, tools).value), tools)


def test_the_user_is_believed_and_told(tmp_path: Path):
    with endpoint(says(openai(answer(book=0.95, gun=0.9)))) as server:
        outcome = described(server, tmp_path, "part.obj", category="sponge")
    assert outcome.value is not None
    category = outcome.value.section.category
    assert (category.value, category.source) == ("sponge", "declared")
    assert [d.code for d in outcome.diagnostics] == ["asset/annotator-refused", "asset/category-contradicted"]
    assert not outcome.review


def test_contradicted_pictures_go_to_a_person(tmp_path: Path):
    with endpoint(says(openai(answer(book=0.95)))) as server:
        outcome = described(server, tmp_path, "sponge.obj")
    assert outcome.value is not None
    assert outcome.review
    assert outcome.value.section.category.value == "unknown"
    assert "asset/category-contradicted" in [d.code for d in outcome.diagnostics]
    pictures = [p for p in json.loads(server.requests[-1].body)["messages"][1]["content"] if p["type"] == "image_url"]
    assert len({p["image_url"]["url"] for p in pictures}) == 4
    assert all(p["image_url"]["url"].startswith("data:image/png;base64,iVBOR") for p in pictures)


def test_a_lost_endpoint_is_left_alone(tmp_path: Path):
    with endpoint(says(openai(answer(book=0.95)))) as server:
        outcome = described(server, tmp_path, "sponge.obj", lost=True)
        assert server.requests == []
    assert outcome.value is not None
    assert outcome.value.section.category.value == "sponge"
    assert [d.code for d in outcome.diagnostics] == ["asset/annotator-unreachable"]


@pytest.mark.parametrize(
    ("flags", "hint"),
    [
        (("--annotator-url", "http://localhost/v1"), "--annotator-model"),
        (("--annotator-model", "looker"), "--annotator-url"),
        (("--annotator-model", "looker", "--annotator-url", "http://u:p@localhost"), "--annotator-url"),
        (("--annotator-model", "l", "--annotator-url", "http://h/v1", "--annotator-kind", "x"), "--annotator-kind"),
        (("--annotator-model", "l", "--annotator-url", "http://h/v1", "--timeout", "100"), "--timeout"),
    ],
)
def test_flags_that_make_no_sense(tmp_path: Path, flags: tuple[str, ...], hint: str):
    done = CliRunner().invoke(app, ["assets", "ingest", str(tmp_path), "--out", str(tmp_path / "out"), *flags])
    assert done.exit_code == 2
    assert hint in done.output
