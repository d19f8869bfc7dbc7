"""Pictures of one variant of a batch, in a process of its own: the entry point of a cell."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import render.frames  # noqa: F401  Loaded once for all processes of a batch.
from cli.replay.frames import NoSuchCamera, draw_variant
from jobs.cache import content_key, file_sha256, write_atomically
from jobs.json_cell import answer
from schemas.diagnostics import InvalidInput, finding
from schemas.replay.documents import VARIANT_FILE
from usdio.write.scene import PACKAGES

PICTURES, DRAWN = "pictures", "drawn.json"


def draw(given: dict[str, Any]) -> dict[str, Any]:
    """The figures of one variant's pictures; what was drawn before of the same variant is left as it is.

    Raises InvalidInput, and RuntimeError when the renderer fails.
    """
    folder = Path(given["folder"])
    key = content_key(file_sha256(folder / VARIANT_FILE), given["cameras"], given["every"])
    note = folder / PICTURES / DRAWN
    if note.is_file() and (done := json.loads(note.read_bytes()))["key"] == key:
        return done
    assets = packages if (packages := Path(given["out"]) / PACKAGES).is_dir() else None
    meshes = Path(given["meshes"]) if given["meshes"] else None
    fresh = folder / f".{PICTURES}"
    shutil.rmtree(fresh, ignore_errors=True)
    try:
        figures = draw_variant(folder, fresh, assets, meshes, given["cameras"], given["every"], quiet=True)
    except NoSuchCamera as error:
        raise InvalidInput(finding("replay/missing-camera", str(error))) from None
    shutil.rmtree(folder / PICTURES, ignore_errors=True)
    fresh.rename(folder / PICTURES)
    note_content = {"key": key, "frames": figures["frames"]}
    write_atomically(note, json.dumps(note_content).encode())
    return note_content


if __name__ == "__main__":
    answer(draw, *sys.argv[1:3])
