"""Damaged copies of real files through the readers, each in a cell with limits: each must end in a value or a code.

    python -m benchmarks.assets.fuzz.run OUT_DIR SEED_DIR... [--count N] [--seed S] [--start I] [--format F] [--full]

A seed is any model file in the folders whose own folder is small; case I with seed S is the same damage on every run.
Prints counts per format and code, and every case that broke a promise, crashed, hung, or raised; such inputs stay in
OUT_DIR. `--full` takes the cases that the readers accept through the whole pipeline.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import tempfile
import time
from collections import Counter, defaultdict
from dataclasses import dataclass
from pathlib import Path
from random import Random

from assetkit.batch.item_cells import LOST_CODES, Batch, run_items
from assetkit.options import Options
from assetkit.readers.by_format import FORMAT_OF
from assetkit.sources.discover import discover
from benchmarks.assets.fuzz.mutations import mutate
from cli.engines import SIMULATOR
from jobs.cell import Limits
from jobs.warm import run_module, warm_cells

LIMITS = Limits(seconds=30.0, memory_mb=8192)
FULL_LIMITS = Limits(seconds=240.0, memory_mb=8192)
MAX_SEED_BYTES, MAX_ROBOT_BYTES = 120_000, 4_000_000  # of a folder; a description needs the meshes that it names
ROBOTS = (".urdf", ".xml", ".mjcf")
BUGS = {"asset/internal-error", "asset/package-invalid", *LOST_CODES.values()}
_NAMES = ("part", "Ünï cödé", "with space", "x" * 200, "a'b", "semi;colon", "#1 %20", "..dots", "-rf", "new\nline")


@dataclass(frozen=True)
class Seed:
    """A model file and the folder with everything it refers to."""

    folder: Path
    file: Path

    @property
    def format(self) -> str:
        """The reader's format."""
        return FORMAT_OF[self.file.suffix.lower()]


def seeds_in(folders: list[Path]) -> list[Seed]:
    """The seeds below `folders`, in the order of their paths; equal names and sizes count once."""
    seeds: dict[tuple[str, int], Seed] = {}
    for candidate in discover(folders):
        path, root = candidate.file.path, candidate.file.root
        if path.suffix.lower() not in FORMAT_OF or path.is_symlink():
            continue
        size = path.stat().st_size
        files = [p for p in root.rglob("*") if p.is_file()]
        if len(files) > 40 or sum(p.stat().st_size for p in files) > most_bytes(path):
            root = path.parent
            files = [path]
        if 0 < size <= MAX_SEED_BYTES and len(files) <= 40:
            seeds.setdefault((path.name, size), Seed(root if len(files) > 1 else path.parent, path))
    return list(seeds.values())


def most_bytes(file: Path) -> int:
    """The most that the folder of a seed may hold."""
    return MAX_ROBOT_BYTES if file.suffix.lower() in ROBOTS else MAX_SEED_BYTES


def make_case(rng: Random, seed: Seed, folder: Path) -> tuple[Path, str]:
    """A damaged copy of `seed` in `folder`: the file to ingest and what was done to it."""
    folder.mkdir(parents=True)
    inner = seed.file.relative_to(seed.folder)
    small = [p for p in seed.folder.rglob("*") if p.is_file() and not p.is_symlink()]
    if len(small) <= 40 and sum(p.stat().st_size for p in small) <= most_bytes(seed.file):
        for path in small:
            target = folder / path.relative_to(seed.folder)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
    else:
        (folder / inner).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(seed.file, folder / inner)
    file = folder / inner
    if rng.random() < 0.06:
        return odd_file(rng, file)
    target = file
    others = [p for p in folder.rglob("*") if p.is_file() and p != file]
    if others and rng.random() < 0.2:
        target = rng.choice(sorted(others))
    data, done = mutate(rng, target.read_bytes(), target.suffix)
    target.write_bytes(data)
    return file, f"{target.name}: {done}"


def odd_file(rng: Random, file: Path) -> tuple[Path, str]:
    """The same content under an odd name or as an odd kind of file."""
    suffix = file.suffix
    match rng.randrange(10):
        case 0:
            file.write_bytes(b"")
            return file, "empty"
        case 1:
            file.unlink()
            file.mkdir()
            return file, "a folder"
        case 2:
            file.unlink()
            file.symlink_to(file.name)
            return file, "a link to itself"
        case 3:
            file.unlink()
            file.symlink_to("/etc/hostname")
            return file, "a link out of the folder"
        case 4:
            file.unlink()
            file.symlink_to("absent" + suffix)
            return file, "a dangling link"
        case 5:
            file.unlink()
            os.mkfifo(file)
            return file, "a pipe"
        case 6:
            other = file.with_suffix(rng.choice(sorted(FORMAT_OF)))
            return file.rename(other), f"called {other.suffix}"
        case 7:
            return file.rename(file.with_suffix(suffix.swapcase())), "mixed case"
        case _:
            return file.rename(file.with_name(rng.choice(_NAMES) + suffix)), "odd name"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("seeds", type=Path, nargs="+")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--format", default="", help="only seeds of this format")
    parser.add_argument("--full", action="store_true", help="whole pipeline for what the readers accept")
    arguments = parser.parse_args()
    by_format: dict[str, list[Seed]] = defaultdict(list)
    for seed in seeds_in(arguments.seeds):
        if arguments.format in ("", seed.format):
            by_format[seed.format].append(seed)
    print({f: len(s) for f, s in by_format.items()})
    arguments.out.mkdir(parents=True, exist_ok=True)
    started = time.monotonic()
    codes: dict[str, Counter[str]] = defaultdict(Counter)
    ends: dict[str, Counter[str]] = defaultdict(Counter)
    accepted: dict[str, str] = {}
    environment = {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(Path(__file__).parents[3])}
    os.environ.update(environment)
    with warm_cells("assetkit.pipeline", env=environment):
        for number in range(arguments.start, arguments.start + arguments.count):
            rng = Random(f"{arguments.seed}:{number}")
            seed = rng.choice(by_format[rng.choice(sorted(by_format))])
            folder = arguments.out / f"case_{number}"
            shutil.rmtree(folder, ignore_errors=True)
            file, done = make_case(rng, seed, folder)
            end, note, trace = run_one(folder, file)
            ends[seed.format][end] += 1
            codes[seed.format].update(note.get("codes", []))
            if end.startswith("BUG"):
                print(f"{number} {end} {seed.file.name} [{done}] {note.get('broken', '')} {trace[-600:]}", flush=True)
            elif end == "value" and arguments.full:
                accepted[str(file)] = f"{number} {seed.file.name} [{done}]"
            else:
                shutil.rmtree(folder, ignore_errors=True)
    print(f"{sum(map(Counter.total, ends.values()))} cases in {time.monotonic() - started:.0f} s")
    for name in sorted(ends):
        print(name, dict(ends[name].most_common()), dict(codes[name].most_common()), flush=True)
    if arguments.full:
        run_full(accepted)


def run_one(folder: Path, file: Path) -> tuple[str, dict, str]:
    """How reading and canonicalizing ended, the cell's note, and the trace of what went wrong."""
    with tempfile.TemporaryDirectory() as scratch:
        note_file = Path(scratch) / "note.json"
        arguments = [str(folder.absolute()), str(file.absolute()), str(note_file)]
        result = run_module("benchmarks.assets.fuzz.one_case", arguments, LIMITS)
        note = json.loads(note_file.read_text()) if note_file.exists() else {}
    if result.status != "ok":
        return f"BUG {result.status}", note, result.output
    if note.get("trace"):
        return "BUG exception", note, note["trace"]
    if note["broken"]:
        return "BUG broken promise", note, ""
    return ("value" if note["made"] else "refused"), note, ""


def run_full(accepted: dict[str, str]) -> None:
    """Take the files of `accepted` (path -> what was done) through the whole pipeline; prints outcomes and bugs."""
    ends: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as out:
        candidates = discover([Path(file) for file in accepted])
        batch = Batch(Path(out), Options(), SIMULATOR, limits=FULL_LIMITS, fresh=True)
        for item in run_items(candidates, batch):
            bugs = BUGS & set(item.codes)
            ends[f"{item.outcome.value}{' BUG' if bugs else ''}"] += 1
            if bugs:
                headlines = [d.headline for d in item.diagnostics if d.code in bugs]
                print(accepted.get(item.source), sorted(bugs), headlines, item.traceback[-600:], flush=True)
    print("whole pipeline", dict(ends))


if __name__ == "__main__":
    main()
