"""A segmenter of the user's own, run as a command in a cell: what it answers is checked, what it breaks is not ours.

The command gets two paths: an `.npz` to read (points (n, 3) in metres, z up, and triangles (m, 3)), and a JSON file to
write: `{"parts": [{"label": "handle", "confidence": 0.8, "triangles": [0, 1, ...]}]}`. What was asked stands in
`question.json` beside it: the category and the part names it may use.
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

from assetkit.parts.proposals import Proposal, Segmented
from geom.features.regions import Faces
from jobs.cell import Limits, run_cell

MOST_BYTES = 16 * 2**20
MOST_PARTS = 64
MOST_SAID = 200
MEMORY_MB = 8192
LIMITS = Limits(seconds=60.0, memory_mb=MEMORY_MB)
SEEN = 0.8  # of the confidence of a model counts, as for categories


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

    def segment(self, surface: Faces, category: str, vocabulary: Sequence[str]) -> Segmented:
        """Proposals in the order of the answer; none without a usable one."""
        with tempfile.TemporaryDirectory() as place:
            surface_file, answer_file = Path(place, "surface.npz"), Path(place, "answer.json")
            np.savez(surface_file, points=surface.points, triangles=surface.triangles)
            asked = {"category": category, "labels": list(vocabulary)}
            Path(place, "question.json").write_text(json.dumps(asked), encoding="utf-8")
            result = run_cell([*self.command, str(surface_file), str(answer_file)], self.limits)
            if result.status != "ok":
                said = (result.output.strip().splitlines() or ["no output"])[-1][:MOST_SAID]
                return Segmented(problem=f"{result.status.replace('_', ' ')}: {said}")
            answer = _read(answer_file)
        if answer is None:
            return Segmented(problem="its answer is missing, too large or of another form")
        known = [region for region in answer.parts if region.label in vocabulary]
        found = [_proposal(region, len(surface.triangles), self.name) for region in known]
        proposals = tuple(p for p in found if p is not None)
        if len(proposals) == len(answer.parts):
            return Segmented(proposals)
        names, places = len(answer.parts) - len(known), len(known) - len(proposals)
        return Segmented(proposals, f"left out: {names} with a name not asked for, {places} with no such triangles")

    @property
    def name(self) -> str:
        """The program as evidence names it: the last word of the command that is a file, else the first, no folders."""
        files = [word for word in self.command if Path(word).is_file()]
        return Path(files[-1] if files else self.command[0]).name


def _read(file: Path) -> _Answer | None:
    """The answer, None unless it is a plain file of bounded size and the form asked for."""
    try:
        if file.is_symlink() or not file.is_file() or file.stat().st_size > MOST_BYTES:
            return None
        data: Any = json.loads(file.read_bytes())
        return _Answer.model_validate(data)
    except (OSError, ValueError, RecursionError, ValidationError):
        return None


def _proposal(region: _Region, count: int, by: str) -> Proposal | None:
    own = region.triangles
    if not own or min(own) < 0 or max(own) >= count:
        return None
    faces = np.zeros(count, dtype=bool)
    faces[own] = True
    return Proposal(faces, "learned", label=region.label, confidence=SEEN * region.confidence, by=by)
