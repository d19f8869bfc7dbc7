"""Runs a generative model of the user as a command: text or a picture in, one mesh file out, with its provenance.

The command gets two paths: `request.json` to read (`{"prompt": "a red mug", "image": "image.png" or null, "seed": 0}`,
the picture beside it) and an empty folder, into which it writes one model file of a format that Mana reads, with the
files to which it refers.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from assetkit.sources.discover import discover
from jobs.cache import file_sha256, write_atomically
from jobs.cell import CellResult, Limits, run_cell
from schemas.diagnostics import InvalidInput, finding

SYNTHESIS_FILE = "synthesis.json"
MOST_ANSWER_BYTES = 2 * 2**30
MOST_FILES = 256
_MOST_OUTPUT_CHARACTERS = 200


@dataclass(frozen=True)
class SynthesisRequest:
    """What a model is given: a prompt, a picture or both, and the seed of its random numbers."""

    prompt: str
    image: Path | None = None
    seed: int = 0


def synthesize(
    command: Sequence[str], digest: str, request: SynthesisRequest, folder: Path, name: str, limits: Limits
) -> Path:
    """The model file NAME.EXT in `folder`, an empty folder or none, with the files beside it and `synthesis.json`.

    `synthesis.json` states the request, hashes of the picture and of the files, the program and `digest`, the hash of
    the program's files. Raises InvalidInput (`asset/synthesis-failed`) when the program fails, is late, or does not
    write exactly one readable model of bounded size.
    """
    with tempfile.TemporaryDirectory() as place:
        question, answer = Path(place, "request.json"), Path(place, "answer")
        answer.mkdir()
        image = None if request.image is None else f"image{request.image.suffix.lower()}"
        if request.image is not None and image is not None:
            shutil.copyfile(request.image, Path(place, image))
        asked = {"prompt": request.prompt, "image": image, "seed": request.seed}
        question.write_text(json.dumps(asked), encoding="utf-8")
        result = run_cell([*command, str(question), str(answer)], limits)
        program = _program(command)
        if result.status != "ok":
            raise _failed(program, _ending(result))
        model = _only_model(answer, program)
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copytree(answer, folder, dirs_exist_ok=True)
    target = folder / f"{name}{model.suffix.lower()}"
    os.replace(folder / model.relative_to(answer), target)
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != SYNTHESIS_FILE)
    stated = {
        **asked,
        "image_sha256": None if request.image is None else file_sha256(request.image),
        "program": program,
        "program_sha256": digest,
        "files": {path.relative_to(folder).as_posix(): file_sha256(path) for path in files},
    }
    write_atomically(folder / SYNTHESIS_FILE, json.dumps(stated, indent=1).encode())
    return target


def _only_model(folder: Path, program: str) -> Path:
    """The one model file in a folder of plain files of bounded number and size."""
    files = [path for path in folder.rglob("*") if not path.is_dir() or path.is_symlink()]
    if any(path.is_symlink() or not path.is_file() for path in files):
        raise _failed(program, "it wrote a link or a special file")
    if len(files) > MOST_FILES or sum(path.stat().st_size for path in files) > MOST_ANSWER_BYTES:
        raise _failed(program, f"it wrote more than {MOST_FILES} files or {MOST_ANSWER_BYTES >> 30} GiB")
    models = discover([folder])
    if len(models) != 1:
        raise _failed(program, f"it wrote {len(models)} models instead of one")
    if models[0].file.path.parent != folder:
        raise _failed(program, "its model lies in a folder below that of the answer")
    return models[0].file.path


def _program(command: Sequence[str]) -> str:
    """The program's name in evidence: the last word that is a file, else the first; no folders."""
    files = [word for word in command if Path(word).is_file()]
    return Path(files[-1] if files else command[0]).name


def _ending(result: CellResult) -> str:
    last = (result.output.strip().splitlines() or ["no output"])[-1][:_MOST_OUTPUT_CHARACTERS]
    return f"{result.status.replace('_', ' ')}: {last}"


def _failed(program: str, why: str) -> InvalidInput:
    return InvalidInput(finding("asset/synthesis-failed", f"'{program}': {why}"))
