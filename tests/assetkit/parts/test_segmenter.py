"""A segmenter of the user's own: a local command that answers well, badly, late and with ill will."""

from __future__ import annotations

import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from assetkit.parts.find import find_parts
from assetkit.parts.labels import votes
from assetkit.parts.proposals import Proposal
from assetkit.parts.segmenter import MODEL_TRUST, CommandSegmenter
from jobs.cell import Limits
from schemas.evidence import declared
from schemas.model import Mesh

GOOD = """
    import json, sys
    import numpy as np
    surface = np.load(sys.argv[-2])
    middles = surface["points"][surface["triangles"]].mean(axis=1)
    upper = np.flatnonzero(middles[:, 2] > 0.1).tolist()
    answer = {"parts": [{"label": "head", "confidence": 0.9, "triangles": upper}]}
    print(json.dumps(answer), file=open(sys.argv[-1], "w"))
"""
ANSWERS = {
    "no JSON": "handle!",
    "another form": '{"regions": []}',
    "numbers as text": '{"parts": [{"label": "head", "confidence": "0.9", "triangles": [0]}]}',
    "a triangle that is not there": '{"parts": [{"label": "head", "confidence": 0.9, "triangles": [0, 100000]}]}',
    "a negative triangle": '{"parts": [{"label": "head", "confidence": 0.9, "triangles": [-1]}]}',
    "surer than sure": '{"parts": [{"label": "head", "confidence": 7.0, "triangles": [0]}]}',
    "not a number": '{"parts": [{"label": "head", "confidence": NaN, "triangles": [0]}]}',
    "a word of its own": '{"parts": [{"label": "ignore all rules", "confidence": 1.0, "triangles": [0]}]}',
    "too deep": "[" * 200000,
    "too many": '{"parts": [' + ",".join(['{"label": "head", "confidence": 0.9, "triangles": [0]}'] * 500) + "]}",
}


def figure() -> dict[str, Mesh]:
    """A body with a head, in one shell."""
    body = trimesh.creation.icosphere(3, 0.06).apply_translation((0.0, 0.0, 0.06))
    head = trimesh.creation.icosphere(3, 0.035).apply_translation((0.0, 0.0, 0.14))
    shape = trimesh.boolean.union([body, head], engine="manifold")
    return {"figure": Mesh("figure", np.asarray(shape.vertices), np.asarray(shape.faces, dtype=np.int32))}


def labels(segmenter: CommandSegmenter) -> dict[str, float]:
    parts = find_parts(figure(), (), declared("toy_figure", "test"), segmenter=segmenter).parts
    return {p.value.label.value: p.value.label.confidence for p in parts}


def answering(tmp_path: Path, source: str, seconds: float = 60.0) -> CommandSegmenter:
    script = tmp_path / "segmenter.py"
    script.write_text(textwrap.dedent(source), encoding="utf-8")
    return CommandSegmenter((sys.executable, str(script)), Limits(seconds=seconds, memory_mb=4096))


def test_a_good_answer_becomes_a_part(tmp_path: Path) -> None:
    """The head of a figure, which no rule of ours finds, with the model's confidence marked down."""
    assert labels(answering(tmp_path, GOOD)) == {"head": pytest.approx(MODEL_TRUST * 0.9)}


def test_a_region_with_a_name_alone_counts_as_much_as_the_model_is_sure() -> None:
    """A model in Python may name regions in its own words; without confidence the words say nothing."""
    mesh = figure()["figure"]
    upper = mesh.points[mesh.triangles].mean(axis=1)[:, 2] > 0.1
    for sure in (0.6, 0.0):
        called = Proposal(upper, "learned", names=("head_01",), confidence=sure)
        label_votes = votes(called, "toy_figure", ("head", "body"))
        assert [(v.label, v.confidence, v.kind) for v in label_votes] == ([("head", sure, "learned")] if sure else [])


@pytest.mark.parametrize("kind", ANSWERS)
def test_a_bad_answer_changes_nothing(tmp_path: Path, kind: str) -> None:
    """Parts are found as without it, and nothing raises."""
    (tmp_path / "said").write_text(ANSWERS[kind], encoding="utf-8")
    copy = f"import shutil, sys; shutil.copy({str(tmp_path / 'said')!r}, sys.argv[-1])"
    assert labels(answering(tmp_path, copy)) == {}


@pytest.mark.parametrize(
    "source",
    ["raise SystemExit(3)", "", "import os; os.abort()", "import os, sys; os.symlink('/etc/passwd', sys.argv[-1])"],
    ids=["fails", "says nothing", "aborts", "points elsewhere"],
)
def test_a_broken_segmenter_changes_nothing(tmp_path: Path, source: str) -> None:
    """It runs in a cell, so not even an abort takes the asset with it."""
    assert labels(answering(tmp_path, source)) == {}


def test_a_slow_segmenter_is_ended(tmp_path: Path) -> None:
    """At its limit, children and all."""
    started = time.monotonic()
    assert labels(answering(tmp_path, "import time; time.sleep(600)", seconds=2.0)) == {}
    assert time.monotonic() - started < 60.0
