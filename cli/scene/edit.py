"""`mana scene edit`: a program compiled again each time one saves it, from where the last scene stood."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

from scenec.compile import Compiled
from scenec.session import Session

WAIT_S = 0.1


def saved(session: Session, program: Path, root: Path, wait_s: float = WAIT_S) -> Iterator[Compiled]:
    """What the program compiles to now, then again whenever a YAML file below `root` changes; without end."""
    while True:
        before = _stamps(root)
        yield session.compile(program)
        while _stamps(root) == before:
            time.sleep(wait_s)


def moved(before: Compiled | None, after: Compiled) -> int | None:
    """How many things of the first scene stand elsewhere than before; None where there is no scene to compare with."""
    if before is None or not before.scenes or not after.scenes:
        return None
    poses = {item.id: (item.position_m, item.quat_wxyz) for item in before.scenes[0].objects}
    return sum(poses.get(item.id) != (item.position_m, item.quat_wxyz) for item in after.scenes[0].objects)


def _stamps(root: Path) -> dict[Path, tuple[int, int]]:
    stamps = {}
    for pattern in ("**/*.yaml", "**/*.yml"):
        for file in root.glob(pattern):
            try:
                state = file.stat()
            except OSError:  # An editor may write a file by putting another in its place.
                continue
            stamps[file] = state.st_mtime_ns, state.st_size
    return stamps
