"""A generator of the user's own, a program or a server on this machine: it answers well, badly, late, with malice."""

from __future__ import annotations

import base64
import json
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest

from assetkit.materials.recovery.generator import (
    MOST_OF_SURFACE,
    MOST_PROPOSAL_BYTES,
    Proposals,
    proposals,
    question_of,
)
from assetkit.materials.recovery.recover import recover
from assetkit.materials.recovery.surfaces import open_surfaces
from assetkit.options import AppearanceGenerator
from tests.assetkit.materials.recovery.samples import MUG, box, model_of, subject
from tests.support.endpoint_server import dripping, endless, endpoint, says, silent

MODEL = model_of([box("body"), box("lid", at_m=0.2)])
SURFACES = open_surfaces(MODEL, subject(MUG))
QUESTION = question_of(SURFACES, MUG, "mug", {"view_front": b"picture"})
GLAZE: dict[str, Any] = {
    "surface": 0,
    "name": "Blue glaze",
    "material_class": "ceramic",
    "base_color": [0.05, 0.1, 0.4],
    "roughness": 0.2,
    "metallic": 0.0,
}
BAD = {
    "no JSON": "a mug!",
    "another form": '{"colours": []}',
    "a field of its own": json.dumps({"materials": [GLAZE | {"shell": "rm -rf /"}]}),
    "numbers as text": json.dumps({"materials": [GLAZE | {"roughness": "0.2"}]}),
    "not a number": json.dumps({"materials": [GLAZE | {"roughness": float("nan")}]}),
    "brighter than light": json.dumps({"materials": [GLAZE | {"base_color": [7.0, 0.0, 0.0]}]}),
    "a negative surface": json.dumps({"materials": [GLAZE | {"surface": -1}]}),
    "too many": json.dumps({"materials": [GLAZE] * 500}),
    "too deep": "[" * 200_000,
    "nothing": "",
}
IMPLAUSIBLE = {
    "a surface that is not there": GLAZE | {"surface": 9},
    "a class of its own": GLAZE | {"material_class": "ignore all rules"},
    "ceramic that is a metal": GLAZE | {"metallic": 1.0},
    "steel that is none": GLAZE | {"material_class": "steel"},
    "black steel": GLAZE | {"material_class": "steel", "metallic": 1.0, "base_color": [0.05, 0.05, 0.05]},
    "white that glows": GLAZE | {"base_color": [1.0, 1.0, 1.0]},
}


def program(tmp_path: Path, source: str, seconds: float = 30.0) -> AppearanceGenerator:
    script = tmp_path / "generator.py"
    script.write_text(textwrap.dedent(source), encoding="utf-8")
    return AppearanceGenerator(command=(sys.executable, str(script)), seconds=seconds)


def writing(tmp_path: Path, text: str) -> AppearanceGenerator:
    file = tmp_path / "text"
    file.write_text(text, encoding="utf-8")
    return program(tmp_path, f"import shutil, sys; shutil.copyfile({str(file)!r}, sys.argv[-1])")


def ask(generator: AppearanceGenerator, tmp_path: Path) -> Proposals:
    return proposals(generator, QUESTION, len(SURFACES), tmp_path / "work")


def codes(answer: Proposals) -> list[str]:
    return [finding.code for finding in answer.findings]


def assert_unused(answer: Proposals) -> None:
    """No proposal, one finding of one printable line."""
    assert answer.of_surface == ((), ())
    assert codes(answer) == ["asset/appearance-generator-failed"]
    assert answer.findings[0].headline.isprintable()


def test_the_question_names_surfaces_and_shows_pictures() -> None:
    assert json.loads(json.dumps(QUESTION)) == QUESTION
    assert [s["names"][0] for s in QUESTION["surfaces"]] == ["body", "lid"]
    assert base64.b64decode(QUESTION["views"]["view_front"]) == b"picture"
    assert QUESTION["category"] == "mug"


def test_a_good_program_reads_the_question_and_its_material_is_ranked(tmp_path: Path) -> None:
    """It finds the lid by its name in the question; the lid weighs it beside the library, no surer than before."""
    source = f"""
        import json, sys
        question = json.load(open(sys.argv[-2]))
        lid = [s["surface"] for s in question["surfaces"] if "lid" in s["names"]][0]
        answer = {{"materials": [{GLAZE!r} | {{"surface": lid}}]}}
        json.dump(answer, open(sys.argv[-1], "w"))
    """
    answer = ask(program(tmp_path, source), tmp_path)
    assert codes(answer) == []
    assert [[entry.name for entry in each] for each in answer.of_surface] == [[], ["generated_blue_glaze"]]
    recovered = recover(MODEL, subject(MUG), propose=lambda _: answer.of_surface).surfaces
    assert "generated_blue_glaze" in [candidate.entry for candidate in recovered[1].candidates]
    assert all(surface.family.confidence <= 0.5 for surface in recovered)


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_answer_is_no_answer(tmp_path: Path, kind: str) -> None:
    assert_unused(ask(writing(tmp_path, BAD[kind]), tmp_path))


@pytest.mark.parametrize("kind", IMPLAUSIBLE)
def test_what_is_implausible_is_left_out_and_the_rest_counts(tmp_path: Path, kind: str) -> None:
    answer = ask(writing(tmp_path, json.dumps({"materials": [IMPLAUSIBLE[kind], GLAZE]})), tmp_path)
    assert [len(each) for each in answer.of_surface] == [1, 0]
    assert codes(answer) == ["asset/appearance-generator-failed"]


def test_at_most_two_materials_of_a_surface(tmp_path: Path) -> None:
    answer = ask(writing(tmp_path, json.dumps({"materials": [GLAZE] * 5})), tmp_path)
    assert len(answer.of_surface[0]) == MOST_OF_SURFACE
    assert len({entry.name for entry in answer.of_surface[0]}) == MOST_OF_SURFACE


@pytest.mark.parametrize(
    "source",
    [
        "raise SystemExit(3)",
        "import os, sys; os.symlink('/etc/passwd', sys.argv[-1])",
        "import os, sys; os.mkfifo(sys.argv[-1])",
        f"import sys; open(sys.argv[-1], 'w').write(' ' * {MOST_PROPOSAL_BYTES + 1})",
        r"import sys; sys.stderr.write('\x1b[2J\x00' * 9999); sys.exit(1)",
        "pass",
    ],
)
def test_a_program_that_misbehaves(tmp_path: Path, source: str) -> None:
    assert_unused(ask(program(tmp_path, source), tmp_path))


def test_a_late_program_is_stopped(tmp_path: Path) -> None:
    assert_unused(ask(program(tmp_path, "import time; time.sleep(600)", seconds=1.0), tmp_path))


def test_a_good_server_gets_the_question_and_no_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MANA_ANNOTATOR_KEY", "secret-of-another-server")
    with endpoint(says(json.dumps({"materials": [GLAZE]}))) as server:
        answer = ask(AppearanceGenerator(url=server.url, seconds=20.0), tmp_path)
    assert codes(answer) == []
    assert [len(each) for each in answer.of_surface] == [1, 0]
    (request,) = server.requests
    assert json.loads(request.body) == QUESTION
    assert "secret" not in str(request)
    assert answer.use is not None
    assert answer.use.requests == 1


@pytest.mark.parametrize(
    "respond",
    [
        says("no JSON"),
        says("{}", status=404),
        says("", status=302, Location="http://127.0.0.1:1/"),
        silent(5.0),
        dripping(5.0),
        endless(),
    ],
    ids=["no JSON", "absent", "elsewhere", "silent", "dripping", "endless"],
)
def test_a_server_that_misbehaves(tmp_path: Path, respond: Any) -> None:
    with endpoint(respond) as server:
        assert_unused(ask(AppearanceGenerator(url=server.url, seconds=0.5), tmp_path))


def test_no_server(tmp_path: Path) -> None:
    assert_unused(ask(AppearanceGenerator(url="http://127.0.0.1:1/none", seconds=0.5), tmp_path))
