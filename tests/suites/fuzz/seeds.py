"""The real files that are damaged: a model, program, plan, recording or measurement with the files it refers to."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import pybullet_data

from assetkit.readers.by_format import FORMAT_OF
from assetkit.sources.discover import discover
from scenec.compile import compile_program
from scenec.plan.document import plan_text
from tests.suites.fuzz.readers.by_format import ASSETS
from tests.support import replay_samples

ROOT = Path(__file__).parents[3]
SHARED = ROOT.parent / "shared" / "data"
MOST_BYTES, MOST_ROBOT_BYTES = 120_000, 4_000_000  # of a folder; a description needs the meshes that it names
MOST_OTHER_BYTES = 1_200_000  # of a measurement or an episode
MOST_FILES = 40
ROBOTS = frozenset({".urdf", ".xml", ".mjcf"})
DIVERSITY = 0.01  # share of poses that plans of seeds may keep: small plans in little time


@dataclass(frozen=True)
class Seed:
    """A file that is read, the folder with everything it refers to, and the format it is read as."""

    format: str
    folder: Path
    file: Path

    @property
    def name(self) -> str:
        """The file below its folder with the folder's name, for reports and random streams."""
        return f"{self.folder.name}/{self.file.relative_to(self.folder).as_posix()}"

    @property
    def files(self) -> tuple[Path, ...]:
        """What a case copies: the small files of the folder, else the file alone."""
        if self.format not in ASSETS:
            return tuple(sorted(p for p in self.folder.rglob("*") if p.is_file()))
        small = [p for p in sorted(self.folder.rglob("*")) if p.is_file() and not p.is_symlink()]
        few = len(small) <= MOST_FILES and sum(p.stat().st_size for p in small) <= most_bytes(self.file)
        return tuple(small) if few else (self.file,)


def most_bytes(file: Path) -> int:
    """The most that the folder of an asset may hold."""
    return MOST_ROBOT_BYTES if file.suffix.lower() in ROBOTS else MOST_BYTES


def asset_seeds(folders: list[Path]) -> list[Seed]:
    """Model files below `folders`, in the order of their paths; equal names and sizes count once."""
    seeds: dict[tuple[str, int], Seed] = {}
    for candidate in discover(folders):
        path, root = candidate.file.path, candidate.file.root
        if path.suffix.lower() not in FORMAT_OF or path.is_symlink():
            continue
        size = path.stat().st_size
        files = [p for p in root.rglob("*") if p.is_file()]
        if len(files) > MOST_FILES or sum(p.stat().st_size for p in files) > most_bytes(path):
            root, files = path.parent, [path]
        if 0 < size <= MOST_BYTES and len(files) <= MOST_FILES:
            folder = root if len(files) > 1 else path.parent
            seeds.setdefault((path.name, size), Seed(FORMAT_OF[path.suffix.lower()], folder, path))
    return list(seeds.values())


def seeds_of(format_name: str, scratch: Path, at_most: int) -> list[Seed]:
    """Up to `at_most` seeds of a format: shared files first, then those of the repository and of PyBullet."""
    others = {"scene": _scenes, "plan": _plans, "episode": _episodes, "measurement": _measurements}
    if format_name in others:
        seeds = list(others[format_name](scratch, at_most))
    else:
        places = [SHARED / "assets" / format_name, SHARED / "assets", Path(pybullet_data.getDataPath())]
        seeds = [s for s in asset_seeds([p for p in places if p.is_dir()]) if s.format == format_name]
    return _spread(list(dict.fromkeys(seeds)), at_most)


def _spread(seeds: list[Seed], at_most: int) -> list[Seed]:
    """`at_most` of the seeds, at equal steps."""
    count = min(at_most, len(seeds))
    return [seeds[k * len(seeds) // count] for k in range(count)]


def _scenes(scratch: Path, at_most: int) -> Iterator[Seed]:
    for folder in (ROOT / "tests" / "data" / "scenes", ROOT / "examples" / "scenes"):
        for file in sorted(folder.glob("*.yaml")):
            alone = scratch / "scenes" / file.stem
            alone.mkdir(parents=True, exist_ok=True)
            for each in {file, *(f for f in folder.glob("*.yaml") if f.name in file.read_text())}:
                (alone / each.name).write_bytes(each.read_bytes())
            yield Seed("scene", alone, alone / file.name)


def _plans(scratch: Path, at_most: int) -> Iterator[Seed]:
    """Plans of the programs that need no packages."""
    count = 0
    for scene in _scenes(scratch, at_most):
        if count < at_most:
            plan = compile_program(scene.file, explain=False, diversity=DIVERSITY).plan
            if plan is not None:
                folder = scratch / "plans" / scene.file.stem
                folder.mkdir(parents=True, exist_ok=True)
                (folder / "plan.json").write_text(plan_text(plan))
                count += 1
                yield Seed("plan", folder, folder / "plan.json")


def _episodes(scratch: Path, at_most: int) -> Iterator[Seed]:
    """Recordings in HDF5 with their meshes, and staged folders of tables."""
    for demos in (1, 2):
        folder = scratch / "episodes" / f"arm_{demos}"
        yield Seed("episode", folder, replay_samples.robomimic(folder / "demo.hdf5", demos=demos))
    folder = replay_samples.staged(scratch / "episodes" / "staged")
    yield Seed("episode", folder, folder / "episode.parquet")
    for file in sorted((SHARED / "episodes").glob("*/raw/*.hdf5")):
        with h5py.File(file) as recording:
            if len(recording) and os.path.getsize(file) <= MOST_OTHER_BYTES:
                yield Seed("episode", file.parent, file)


def _measurements(scratch: Path, at_most: int) -> Iterator[Seed]:
    for spec in sorted((SHARED / "measured" / "foreign").glob("*/measurement.yaml")):
        files = [p for p in spec.parent.rglob("*") if p.is_file()]
        if sum(p.stat().st_size for p in files) <= MOST_OTHER_BYTES:
            yield Seed("measurement", spec.parent, spec)
