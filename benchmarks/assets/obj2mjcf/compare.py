"""A full ingest beside `obj2mjcf --decompose` on the same OBJ files, in one run.

    python -m benchmarks.assets.obj2mjcf.compare [FOLDER ...] --out DIR [--files N] [--cpu-limit S]
    python -m benchmarks.assets.obj2mjcf.compare --scale 10,50,100 --out DIR

Without FOLDER: the shared dev assets beside the repository, PyBullet's data and its random objects, as far as present;
`--files` takes so many of each folder, evenly spread over their names. Each file is copied with what it refers to, then
one tool after the other runs on it, in turn first. Ours runs every stage, nothing from the store, one process at a
time. Rows are kept in `DIR/assets.csv`: the same command continues where it was stopped. `DIR/assets.md` holds the
table and the medians.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import shutil
import sys
from pathlib import Path

from assetkit.package.record import read_record
from assetkit.readers.obj.read import read_obj
from assetkit.sources.discover import discover
from benchmarks.assets import scale
from benchmarks.assets.obj2mjcf import tool
from benchmarks.assets.obj2mjcf.likeness import Likeness, likeness, package_parts, source_mesh
from benchmarks.assets.obj2mjcf.table import Row, line, read_rows, summary, write_rows
from benchmarks.running import Cost, run
from cli.demo.app import data_folder
from schemas.diagnostics import InvalidInput

SHARED = Path(__file__).parents[3].parent / "shared" / "data" / "assets"
RANDOM = "random_urdfs"
NONE = Likeness(0, float("nan"), float("nan"), float("nan"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="*")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--files", type=int, default=0, help="how many files of each folder; 0: all")
    parser.add_argument("--cpu-limit", type=int, default=120, help="seconds of processor time obj2mjcf may take")
    parser.add_argument("--scale", default="", help="numbers of assets, e.g. 10,50,100,250,500: measure growth instead")
    parser.add_argument("--jobs", default="1,2", help="with --scale: numbers of workers")
    arguments = parser.parse_args()
    out = arguments.out.absolute()
    out.mkdir(parents=True, exist_ok=True)
    if arguments.scale:
        scale.measure([int(n) for n in arguments.scale.split(",")], [int(n) for n in arguments.jobs.split(",")], out)
        return
    python = tool.environment(out / "obj2mjcf-env")
    folders = arguments.folders or [f for f in (SHARED / "obj", data_folder(), data_folder() / RANDOM) if f.is_dir()]
    files = [file for folder in folders for file in spread(obj_files(folder), arguments.files)]
    rows = {row.file: row for row in read_rows(out / "assets.csv")}
    for number, file in enumerate(files):
        if label(file) in rows:
            continue
        row = compare(file, python, out / "work", arguments.cpu_limit, ours_first=number % 2 == 0)
        if row is not None:
            rows[row.file] = row
            write_rows(list(rows.values()), out)
            print(line(row), flush=True)
    done = [row for row in rows.values() if row.compared]
    together = in_one_command(
        [file for file in files if label(file) in {row.file for row in done}], python, out / "work"
    )
    text = f"{summary(list(rows.values()))}\n{together}{sum(row.theirs_cpu_s for row in done) / len(done):.2f}."
    (out / "summary.md").write_text(f"{text}\n")
    print(text)


def obj_files(folder: Path) -> list[Path]:
    """OBJ files below a folder; PyBullet's thousand random objects only when their folder is named."""
    return [file for file in sorted(folder.rglob("*.obj")) if RANDOM not in file.relative_to(folder).parts]


def spread(files: list[Path], count: int) -> list[Path]:
    """`count` of the files at even steps, all if 0."""
    return files if not 0 < count < len(files) else [files[i * len(files) // count] for i in range(count)]


def label(file: Path) -> str:
    """A short name that distinguishes files on every machine."""
    return f"{file.parent.name}/{file.name}"


def compare(file: Path, python: Path, work: Path, cpu_limit_s: int, *, ours_first: bool) -> Row | None:
    """One row, or None for a file that trimesh finds no triangles in."""
    shutil.rmtree(work, ignore_errors=True)
    for_ours, for_theirs = copied(file, work / "ours"), copied(file, work / "theirs")
    points, triangles = source_mesh(for_ours)
    if not len(triangles):
        return None
    early = ingest([for_ours], work / "out") if ours_first else None
    theirs = tool.convert(python, for_theirs, cpu_limit_s)
    ours = early or ingest([for_ours], work / "out")
    ended, packages = outcome(work / "out")
    parts = [part for package in packages for part in package_parts(package)]
    their_parts = tool.hulls(for_theirs)
    our_likeness = likeness(parts, points, triangles) if parts else NONE
    their_likeness = likeness(their_parts, points, triangles) if their_parts else NONE
    return Row(
        label(file),
        len(triangles),
        ended,
        "+".join(sorted({record.physics.collision_method for p in packages if (record := read_record(p))})),
        *figures(ours, our_likeness),
        ending(theirs, for_theirs.parent),
        *figures(theirs, their_likeness),
    )


def in_one_command(files: list[Path], python: Path, work: Path) -> str:
    """The beginning of a sentence about the files that both tools finish, ours in a single command."""
    shutil.rmtree(work, ignore_errors=True)
    copies = [copied(file, work / "all" / str(number)) for number, file in enumerate(files)]
    cost = ingest(copies, work / "out")
    nothing = tool.convert(python, work / "no_such_file.obj", 0)
    return (
        f"- all {len(files)} compared files in one command, CPU s an asset: ours {cost.cpu_s / len(files):.2f} (peak "
        f"{cost.together_mb:.0f} MiB together); obj2mjcf, of which {nothing.cpu_s:.2f} s are its start: "
    )


def ingest(files: list[Path], out: Path) -> Cost:
    """Cost of our command on these files, every stage anew, one at a time."""
    argv = [sys.executable, "-P", "-m", "cli.main", "assets", "ingest", *map(str, files), "--out", str(out)]
    return run([*argv, "--fresh", "--jobs", "1", "--json"], env={})


def copied(file: Path, folder: Path) -> Path:
    """A copy of an OBJ file with the materials and textures it refers to, as far as they lie beside or below it."""
    source = discover([file])[0].file
    with contextlib.suppress(InvalidInput):  # Its ingest will say so.
        read_obj(source)
    here = file.parent.resolve()
    for path in (p for p in {file.resolve(), *source.visited} if p.is_relative_to(here)):
        target = folder / path.relative_to(here)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target)
    return folder / file.name


def outcome(out: Path) -> tuple[str, list[Path]]:
    """How our ingest ended, and the packages it made."""
    if not (out / "report.json").is_file():
        return "no report", []
    item = json.loads((out / "report.json").read_text())["items"][0]
    return item["outcome"], [out / name for name in item["packages"]]


def ending(cost: Cost, folder: Path) -> str:
    """How obj2mjcf ended: `ok`, `time-out`, or the last line it printed, without the path of its `folder`."""
    if cost.returncode == 0:
        return "ok"
    if cost.returncode == -24 or cost.wall_s > 1800.0:
        return "time-out"
    lines = cost.output.strip().splitlines()
    return (lines[-1] if lines else f"exit {cost.returncode}").replace(f"{folder}/", "")[:100]


def figures(cost: Cost, near: Likeness) -> tuple[float, float, int, int, int, float, float, float]:
    memory = (round(cost.process_mb), round(cost.together_mb))
    distances = (round(near.p95, 3), round(near.mean, 3), round(near.largest, 3))
    return (round(cost.cpu_s, 2), round(cost.wall_s, 2), *memory, near.hulls, *distances)


if __name__ == "__main__":
    main()
