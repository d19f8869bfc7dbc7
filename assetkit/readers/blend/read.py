"""Reads a .blend file into a Model: Blender converts it to GLB in a child process, and the glTF reader reads that."""

from __future__ import annotations

import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from assetkit.blender import environment
from assetkit.readers.common.corners import Notes, repaired
from assetkit.readers.common.sniff import screen
from assetkit.readers.gltf.read import read_gltf
from assetkit.sources.source_file import SourceFile
from jobs.cell import CellResult, Limits, run_cell
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.evidence import BY_STANDARD, Evidence, declared
from schemas.model import Model
from schemas.outcome import Outcome

OLDEST, NEWEST = 248, 500  # versions as .blend files have them, 2.48 and 5.0: what bpy 5.0.1 reads
WORKER: Final = Path(environment.__file__).with_name("worker.py")
LIMITS = Limits(seconds=240.0, memory_mb=16384)  # also limited by the cell of the asset
_FIRST_BYTES = 4096


def read_blend(source: SourceFile) -> Outcome[Model]:
    """The model of a .blend file: what its scene shows in renders, modifiers applied, at the first frame; z up.

    Blender runs without scripts, drivers and handlers. Linked libraries and pictures must lie within the root. Raises
    InvalidInput: `asset/blender-missing`, `asset/blend-version`, `asset/truncated`, `asset/parse-error`,
    `asset/path-escape`, `asset/wrong-content`, `asset/empty-geometry`, `asset/resource-limit`, `asset/worker-timeout`.
    """
    where = Location(file=source.relative)
    with source.path.open("rb") as file:
        screen(file.read(_FIRST_BYTES), "blend", where=where)
    python = environment.python()
    if python is None:
        raise InvalidInput(finding("asset/blender-missing", "a .blend file is read by Blender, which is not set up"))
    with tempfile.TemporaryDirectory(prefix="mana") as folder:
        glb = Path(folder) / "converted.glb"
        looked = _ask(python, "look", source, where, Path(folder))
        _check(looked, source, where)
        root = str(source.root.resolve())
        answer = _ask(python, "convert", source, where, Path(folder), str(glb), root)
        _check_converted(answer, where)
        source.visited.update(Path(file) for file in answer["read"])
        converted = read_gltf(SourceFile(glb, Path(folder)))
    if converted.value is None:
        return converted
    model = replace(
        converted.value,
        meters_per_unit=_unit(answer),
        up_axis=declared("z", "Blender's frame is z-up"),
        hints=(),
        metadata={k: v for k, v in converted.value.metadata.items() if k != "generator"},
    )
    kept = [note.model_copy(update={"where": where}) for note in converted.diagnostics]
    notes = Notes(tuple(kept), converted.repairs) + _notes(answer, source, where)
    return Outcome(model, notes.diagnostics, notes.repairs)


def _ask(python: Path, what: str, source: SourceFile, where: Location, folder: Path, *more: str) -> dict[str, Any]:
    """The answer of the worker. Raises InvalidInput when it ends without one."""
    note = folder / f"{what}.json"
    argv = [str(python), "-I", str(WORKER), what, str(source.path.resolve()), *more, str(note)]
    ended = run_cell(argv, LIMITS, env={"PYTHONPATH": "", "HOME": str(folder), "XDG_CONFIG_HOME": str(folder)})
    if ended.status != "ok" or not note.is_file():
        raise InvalidInput(_ended(ended, where))
    return json.loads(note.read_text())


def _ended(ended: CellResult, where: Location) -> Diagnostic:
    """The finding for a worker that ended early."""
    last = (ended.output.strip().splitlines() or ["no output"])[-1][:200]
    if ended.status == "timeout":
        return finding("asset/worker-timeout", "Blender took too long", where=where, bound=LIMITS.seconds, unit="s")
    if ended.status == "out_of_memory" or last == "too large":
        headline = "Blender ran out of memory"
        return finding("asset/resource-limit", headline, where=where, bound=LIMITS.memory_mb, unit="MiB")
    return finding("asset/parse-error", f"Blender cannot read it: {last}", where=where)


def _check(looked: dict[str, Any], source: SourceFile, where: Location) -> None:
    """Raises InvalidInput for what must not be opened by Blender at all."""
    if not looked["blend"]:
        headline = "the file is named .blend but holds something else"
        raise InvalidInput(finding("asset/wrong-content", headline, where=where, bound="blend"))
    if not looked["complete"]:
        raise InvalidInput(finding("asset/truncated", "the last block of the file is missing", where=where))
    if not OLDEST <= looked["version"] <= NEWEST:
        shown = f"{looked['version'] // 100}.{looked['version'] % 100:02d}"
        bound = f"{OLDEST / 100:.2f} to {NEWEST / 100:.2f}"
        headline = f"the file was saved by Blender {shown}"
        raise InvalidInput(finding("asset/blend-version", headline, where=where, value=shown, bound=bound))
    for library in looked["libraries"]:
        source.resolve(library.removeprefix("//"), where=where)


def _check_converted(answer: dict[str, Any], where: Location) -> None:
    if "error" in answer:
        last = answer["error"].splitlines()[-1].rpartition("': ")[2]
        raise InvalidInput(finding("asset/parse-error", f"Blender cannot read it: {last}", where=where))
    if "escapes" in answer:
        shown = answer["escapes"][0]
        headline = f"the picture '{shown}' lies outside the folder of the asset"
        raise InvalidInput(finding("asset/path-escape", headline, where=where, value=shown, bound="root"))
    if answer.get("empty"):
        raise InvalidInput(finding("asset/empty-geometry", "the scene shows no mesh in renders", where=where))


def _unit(answer: dict[str, Any]) -> Evidence[float]:
    """Metres per unit by the scene's settings; without a system of units Blender's exporters count metres."""
    if answer["scale"] is None:
        return declared(1.0, "Blender scene without a system of units: metres", confidence=BY_STANDARD)
    return declared(float(answer["scale"]), f"Blender scene unit settings ({answer['system'].lower()}, unit scale)")


def _notes(answer: dict[str, Any], source: SourceFile, where: Location) -> Notes:
    notes = Notes()
    for picture in answer["absent"]:
        source.missing.add(picture.removeprefix("//"))
        missing = finding("asset/missing-texture", f"the image '{picture}' is absent", where=where, value=picture)
        notes += repaired(missing, "missing_texture", texture=picture)
    if answer["actions"]:
        headline = f"{answer['actions']} animations are left out; meshes stand as at the first frame"
        notes += Notes((finding("asset/animation-dropped", headline, where=where, value=answer["actions"]),))
    if answer["loose"]:
        headline = f"{answer['loose']} points without a face are left out"
        left_out = finding("asset/geometry-left-out", headline, where=where, value=answer["loose"])
        notes += repaired(left_out, "loose_geometry", points=answer["loose"])
    if answer["hidden"]:
        headline = f"{answer['hidden']} objects that are hidden in renders are left out"
        notes += Notes((finding("asset/geometry-left-out", headline, where=where, value=answer["hidden"]),))
    return notes
