"""Makes one damaged copy of a seed: the same for the same seed number, wherever and whenever it is made."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from random import Random

from assetkit.readers.by_format import FORMAT_OF
from tests.suites.fuzz.mutations.by_suffix import mutate
from tests.suites.fuzz.mutations.text import OUTSIDE
from tests.suites.fuzz.seeds import Seed

ODD_FILE_SHARE, OTHER_FILE_SHARE = 0.06, 0.25  # of cases: the file is odd as such; another file is damaged
_ASCII_NAMES = ("with space", "x" * 200, "a'b", "semi;colon", "#1 %20", "..dots", "-rf", "$(id)", "a|b", "CON")
_NAMES = (*_ASCII_NAMES, "part", "Ünï cödé", "new\nline", "\x1b[31mred\x1b[0m", os.fsdecode(b"\xff\xfe"), "\u202egnp")


def make_case(stream: str, seed: Seed, place: Path) -> tuple[Path, Path, str]:
    """A damaged copy of `seed` below `place`: its folder, the file to read, and what was done to it.

    Beside the folder lies `place/outside`, which damaged references name and nothing may read.
    """
    rng = Random(f"{stream}:{seed.format}:{seed.name}")
    folder = place / "case"
    folder.mkdir(parents=True)
    for path in seed.files:
        target = folder / path.relative_to(seed.folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
    file = folder / seed.file.relative_to(seed.folder)
    if rng.random() < ODD_FILE_SHARE:
        file, done = odd_file(rng, file)
        return folder, file, done
    target = file
    others = sorted(p for p in folder.rglob("*") if p.is_file() and p != file)
    if others and rng.random() < OTHER_FILE_SHARE:
        target = rng.choice(others)
    data, done = mutate(rng, target.read_bytes(), target.suffix)
    target.write_bytes(data.replace(OUTSIDE, str(place / "outside").encode()))
    return folder, file, f"{target.name}: {done}"


def odd_file(rng: Random, file: Path) -> tuple[Path, str]:
    """The same content under an odd name or as an odd kind of file."""
    suffix = file.suffix
    match rng.randrange(12):
        case 0:
            file.write_bytes(b"")
            return file, "empty"
        case 1:
            file.unlink()
            file.mkdir()
            return file, "a folder"
        case 2:
            return _linked(file, file.name), "a link to itself"
        case 3:
            return _linked(file, "/etc/hostname"), "a link out of the folder"
        case 4:
            return _linked(file, f"../outside/secret{suffix}"), "a link to the folder beside"
        case 5:
            return _linked(file, "absent" + suffix), "a dangling link"
        case 6:
            file.unlink()
            os.mkfifo(file)
            return file, "a pipe"
        case 7:
            other = file.with_suffix(rng.choice(sorted(FORMAT_OF)))
            return file.rename(other), f"called {other.suffix}"
        case 8:
            return file.rename(file.with_suffix(suffix.swapcase())), "mixed case"
        case 9:
            shutil.copyfile(file, file.with_name(f"{file.stem}.copy{suffix}"))
            return file, "twice"
        case _:
            return file.rename(file.with_name(rng.choice(_NAMES) + suffix)), "odd name"


def _linked(file: Path, to: str) -> Path:
    file.unlink()
    file.symlink_to(to)
    return file
