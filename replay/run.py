"""Augmentation of recorded episodes as one call: recordings in, a folder of variants with new static objects out.

Each recording is worked on in a cell (child process with limits); finished episodes are kept from run to run.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jobs.cell import Limits
from jobs.json_cell import ONE_THREAD, ask
from jobs.placement import Placement, cells_at
from jobs.schedule import run_all
from schemas.diagnostics import Diagnostic

LIMITS = Limits(seconds=3600.0, memory_mb=8192)
WORKER = "replay.augment_worker"


@dataclass(frozen=True)
class Augmented:
    """Rows of finished episodes by source and name, sources that were refused with the reason, folders of variants."""

    rows: tuple[dict[str, Any], ...]
    refused: tuple[tuple[Path, Diagnostic], ...]
    folders: tuple[Path, ...]


def augment(
    episodes: Sequence[str | Path],
    out: str | Path,
    *,
    plan: str | Path | None = None,
    assets: str | Path | None = None,
    candidates: str | None = None,
    variants: int = 10,
    objects: int = 3,
    seed: int = 0,
    clearance_m: float = 0.01,
    most_hidden: float = 1.0,
    supports: Sequence[str] = (),
    meshes: str | Path | None = None,
    scene: str | Path | None = None,
    placement: Placement = Placement(),
    progress: Callable[[int, int], None] | None = None,
) -> Augmented:
    """Put `objects` static objects into `variants` copies of each recording, clear of all that moves by `clearance_m`.

    Objects are those of a `plan`; without one, `candidates` names the function that offers packages below `assets`, as
    `"module:function"` (`cli.replay.candidates:candidates`). Recorded states and stamps are copied bit for bit. At most
    the share `most_hidden` of the task objects is newly hidden from the recorded cameras. `progress` is called with
    (recordings done, recordings in all). Finished episodes below `out` are not made again.
    """
    shared = {"plan": _text(plan), "assets": _text(assets), "supports": list(supports)}
    amounts = {"variants": variants, "objects": objects, "seed": seed}
    options = {**amounts, "clearance_m": clearance_m, "most_hidden": most_hidden, **shared}
    paths = {"out": str(out), "meshes": _text(meshes), "scene": _text(scene)}
    request = {**shared, **paths, "candidates": candidates, "options": options}
    rows: list[dict[str, Any]] = []
    refused: list[tuple[Path, Diagnostic]] = []
    sources = [source for path in episodes for source in recordings_below(Path(path))]
    prefixes = distinct_prefixes(sources)
    report_progress = progress or (lambda done, total: None)
    Path(out).mkdir(parents=True, exist_ok=True)
    with cells_at(placement, WORKER, env=ONE_THREAD, shared=[Path(out)]) as jobs:
        report_progress(0, len(sources))
        requests = {source: {**request, "source": str(source), "prefix": prefixes[source]} for source in sources}

        def augmented(path: Path) -> dict[str, Any]:
            return ask(WORKER, requests[path], LIMITS, path.name, stopped="replay/stopped", scratch=Path(out))

        answers = run_all(augmented, sources, jobs=jobs)
        for done, (source, answer) in enumerate(answers, start=1):
            if "refused" in answer:
                refused.append((source, Diagnostic.model_validate(answer["refused"])))
            rows += answer.get("rows", [])
            report_progress(done, len(sources))
    rows.sort(key=lambda row: (row["source"], row["episode"]))
    folders = tuple(Path(out) / (prefixes[Path(row["source"])] + row["episode"]) for row in rows)
    return Augmented(tuple(rows), tuple(refused), folders)


def recordings_below(path: Path) -> Iterator[Path]:
    """The path itself where it is a recording, else the recordings in the folder, in the order of their names."""
    from replay.recording.formats.read import is_recording

    if path.is_file() or is_recording(path):
        yield path
        return
    below = [child for child in sorted(path.iterdir()) if is_recording(child)]
    yield from below or [path]


def distinct_prefixes(sources: Sequence[Path]) -> dict[Path, str]:
    """A prefix of the output of each recording: where several share a name, the folders above them that differ."""
    prefixes = dict.fromkeys(sources, "")
    depth = 0
    while depth < max((len(source.parts) for source in sources), default=0):
        names = Counter(prefixes[source] + source.stem for source in prefixes)
        shared = [source for source in prefixes if names[prefixes[source] + source.stem] > 1]
        if not shared:
            break
        depth += 1
        for source in shared:
            prefixes[source] = "_".join(source.parent.parts[-depth:]).replace("/", "") + "_"
    return prefixes


def _text(path: str | Path | None) -> str | None:
    return None if path is None else str(path)
