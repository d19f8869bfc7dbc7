"""Entry point of an augmentation cell: variants with new objects of all recordings of one source.

The request is JSON: source, folders, options, and the name of the function that offers candidates. Finished episodes
with the same options and inputs are kept.
"""

from __future__ import annotations

import json
import shutil
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

from jobs.cache import content_key, file_sha256, write_atomically
from jobs.json_cell import answer
from replay.augmentation import PreparedEpisode, insertion_shortfall, prepare, variants
from replay.envelope.envelope import Settings
from replay.insertion.candidates import from_plan
from replay.recording.formats.digests import stream_digests
from replay.recording.formats.read import read_episodes
from replay.recording.formats.write import write_variant
from replay.recording.recorded_numbers import invalid_recording
from runtime_plan import load
from schemas.diagnostics import InvalidInput, finding
from schemas.replay.documents import VARIANT_FILE, Variant
from sim.named_engine import load_engine
from usdio.write.scene import PACKAGES, copy_package

DONE = "augmented.json"


def augment(request: dict[str, Any]) -> dict[str, Any]:
    """`rows`, one for each episode of the source. What was finished before with the same options is left as it is."""
    paths = {key: Path(request[key]) if request[key] else None for key in ("meshes", "scene", "plan", "assets")}
    out = Path(request["out"])
    draw, left_out = _candidates(request["candidates"], paths["plan"], paths["assets"])
    digests, rows = _digests(paths["plan"], paths["assets"], paths["scene"]), []
    for episode in read_episodes(Path(request["source"]), paths["meshes"], paths["scene"]):
        folder = out / (request["prefix"] + episode.name)
        key = content_key(request["options"], digests, sorted(stream_digests(episode.source, episode.part).items()))
        row = _finished_row(folder, request["source"], key)
        if row is None:
            started = time.process_time()
            prepared = prepare(episode, Settings(clearance_m=request["options"]["clearance_m"]), request["supports"])
            cpu_s = time.process_time() - started
            row = _write_variants(prepared, draw, request, folder)
            row |= {"packages_left_out": left_out, "key": key, "envelope_cpu_s": round(cpu_s, 3)}
            write_atomically(folder / DONE, json.dumps(row, indent=1).encode())
        rows.append(row)
    return {"rows": rows}


def _candidates(name: str | None, plan: Path | None, assets: Path | None) -> tuple[Any, list[str]]:
    """The function that draws candidates, and packages left out: from the named function, else from the plan."""
    if name is not None:
        return load_engine(name)(plan, assets)
    if plan is None:
        raise InvalidInput(finding("replay/no-candidates", "no plan, and no function that offers candidates"))
    return partial(from_plan, load(plan, assets)), []


def _digests(plan: Path | None, assets: Path | None, scene: Path | None) -> list[str]:
    """Digests of the inputs beside the recording: a changed plan, package or scene makes another job."""
    records = [] if assets is None else sorted(assets.glob("*/record.json"))
    return [file_sha256(file) for file in (plan, scene, *records) if file is not None]


def _finished_row(folder: Path, source: str, key: str) -> dict[str, Any] | None:
    """The row of a finished job, None where it is to be done; only variants of this source are ever replaced.

    Raises InvalidInput (`replay/out-taken`).
    """
    note = folder / DONE
    if not note.is_file():
        strange = [p.name for p in folder.iterdir() if not (p / VARIANT_FILE).is_file()] if folder.is_dir() else []
        if strange:
            raise invalid_recording(
                "replay/out-taken", f"'{folder.name}' below --out holds '{sorted(strange)[0]}'", folder.name
            )
        return None
    try:
        row = json.loads(note.read_bytes())
        row_source, made_as = row["source"], row["key"]
    except (ValueError, KeyError, TypeError):
        raise invalid_recording(
            "replay/out-taken", f"'{folder.name}/{DONE}' below --out is not ours", folder.name
        ) from None
    if row_source != source:
        raise invalid_recording(
            "replay/out-taken", f"'{folder.name}' below --out has variants of {row_source}", folder.name
        )
    return row if made_as == key else None


def _write_variants(prepared: PreparedEpisode, draw: Any, request: dict[str, Any], folder: Path) -> dict[str, Any]:
    options, episode = request["options"], prepared.episode
    assets = Path(request["assets"]) if request["assets"] else None
    for old in folder.glob("variant_*"):
        shutil.rmtree(old)
    written: list[Variant] = []
    for variant in variants(
        prepared, draw, range(options["variants"]), options["objects"], options["seed"], assets, options["most_hidden"]
    ):
        stated = variant.model_copy(
            update={
                "source": str(episode.source),
                "provenance": _provenance(request),
                "meshes": request["meshes"] or "",
            }
        )
        written.append(write_variant(episode, stated, folder / f"variant_{variant.number:04d}"))
    for package in sorted({one.package for variant in written for one in variant.inserted if one.package}):
        copy_package(Path(request["assets"]) / package, Path(request["out"]) / PACKAGES / package)
    return {"episode": episode.name, "source": request["source"], **_figures(prepared, written)}


def _figures(prepared: PreparedEpisode, written: list[Variant]) -> dict[str, Any]:
    counts = sorted(len(variant.inserted) for variant in written)
    short = [
        d.model_dump(mode="json") for variant in written if (d := insertion_shortfall(prepared, variant)) is not None
    ]
    return {
        "variants": len(written),
        "objects_requested": written[0].objects_requested if written else 0,
        "objects_inserted": {"min": counts[0], "median": counts[len(counts) // 2]} if counts else {},
        "most_hidden": max((max(v.camera_hidden.values(), default=0.0) for v in written), default=0.0),
        "capsules": len(prepared.envelope.body),
        "supports": {
            site.free_space.support.name: round(site.free_space.support.area.area, 4) for site in prepared.sites
        },
        "diagnostics": short[:3],
        "short_variants": len(short),
    }


def _provenance(request: dict[str, Any]) -> dict[str, str]:
    return {key: Path(request[key]).name for key in ("plan", "assets") if request[key]}


if __name__ == "__main__":
    answer(augment, *sys.argv[1:3])
