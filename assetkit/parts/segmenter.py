"""Runs the user's segmenter as a command in a child process; its checked answer becomes part proposals.

The command gets two paths: an `.npz` to read (points (n, 3) in metres, z up, and triangles (m, 3)), and a JSON file to
write: `{"parts": [{"label": "handle", "confidence": 0.8, "triangles": [0, 1, ...]}]}`. `question.json`
beside it holds the category and the part names that it may use.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from assetkit.parts.proposals import Proposal, SegmenterResult
from geom.features.regions import FaceGeometry
from jobs.cell import Limits, run_cell

MOST_BYTES = 16 * 2**20
MOST_PARTS = 64
MAX_OUTPUT_CHARACTERS = 200
SEGMENTER_MEMORY_MB = 8192
LIMITS = Limits(seconds=60.0, memory_mb=SEGMENTER_MEMORY_MB)
MODEL_TRUST = 0.8  # of the confidence of a model counts, as for categories


class _Region(BaseModel):
    """One region; `strict` so that neither text nor a truth value passes for a number."""

    model_config = ConfigDict(strict=True)

    label: str = Field(max_length=80)
    confidence: float = Field(ge=0.0, le=1.0, allow_inf_nan=False)
    triangles: list[int]


class _Answer(BaseModel):
    parts: list[_Region] = Field(max_length=MOST_PARTS)


@dataclass(frozen=True)
class CommandSegmenter:
    """Runs `command` with the paths of question and answer behind it; a `Segmenter` of `assetkit.parts.proposals`.

    An answer that is late, missing, too large or of another form is no answer at all: the parts are then found as
    without it. Regions with triangles that do not exist or a label outside the vocabulary are left out one by one.
    """

    command: tuple[str, ...]
    limits: Limits = LIMITS

    def segment(self, surface: FaceGeometry, category: str, vocabulary: Sequence[str]) -> SegmenterResult:
        """Proposals in the order of the answer; none without a usable one."""
        with tempfile.TemporaryDirectory() as place:
            surface_file, answer_file = Path(place, "surface.npz"), Path(place, "answer.json")
            np.savez(surface_file, points=surface.points, triangles=surface.triangles)
            question = {"category": category, "labels": list(vocabulary)}
            Path(place, "question.json").write_text(json.dumps(question), encoding="utf-8")
            result = run_cell([*self.command, str(surface_file), str(answer_file)], self.limits)
            if result.status != "ok":
                last_line = (result.output.strip().splitlines() or ["no output"])[-1][:MAX_OUTPUT_CHARACTERS]
                return SegmenterResult(problem=f"{result.status.replace('_', ' ')}: {last_line}")
            answer = _read(answer_file)
        if answer is None:
            return SegmenterResult(problem="its answer is missing, too large or of another form")
        known = [region for region in answer.parts if region.label in vocabulary]
        checked = [_proposal(region, len(surface.triangles), self.name) for region in known]
        proposals = tuple(p for p in checked if p is not None)
        if len(proposals) == len(answer.parts):
            return SegmenterResult(proposals)
        names, places = len(answer.parts) - len(known), len(known) - len(proposals)
        return SegmenterResult(
            proposals, f"left out: {names} with a name not asked for, {places} with no such triangles"
        )

    @property
    def name(self) -> str:
        """The program's name in evidence: the last word of the command that is a file, else the first; no folders."""
        files = [word for word in self.command if Path(word).is_file()]
        return Path(files[-1] if files else self.command[0]).name


def _read(file: Path) -> _Answer | None:
    """The answer, None unless it is a plain file of bounded size and the expected form."""
    try:
        if file.is_symlink() or not file.is_file() or file.stat().st_size > MOST_BYTES:
            return None
        data: Any = json.loads(file.read_bytes())
        return _Answer.model_validate(data)
    except (OSError, ValueError, RecursionError, ValidationError):
        return None


def _proposal(region: _Region, count: int, by: str) -> Proposal | None:
    triangles = region.triangles
    if not triangles or min(triangles) < 0 or max(triangles) >= count:
        return None
    faces = np.zeros(count, dtype=bool)
    faces[triangles] = True
    return Proposal(faces, "learned", label=region.label, confidence=MODEL_TRUST * region.confidence, by=by)
