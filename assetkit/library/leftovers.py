"""Files and folders that a process which was killed leaves in a library: written aside and never moved into place."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from assetkit.batch.item_cells import WORK

# Names under which Mana writes files and folders aside, to move them into place when they are whole.
_ASIDE = re.compile(r"\.(report\.(html|json|new)|catalog\.sqlite(-journal|-wal|-shm)?|probe-mana-\w+|mana\w+|.+\.\d+)")


def replaced_packages(out: Path) -> Iterator[tuple[Path, Path]]:
    """Each package that stands aside as `.NAME.old`, with the place from which it was moved."""
    for old in sorted(out.glob(".*.old")):
        yield old, out / old.name.removeprefix(".").removesuffix(".old")


def written_aside(out: Path) -> list[Path]:
    """What was written aside in `out` itself, and the files of its running batch; the caller holds the folder's lock,
    so that no process works on them.
    """
    work = out / WORK
    return [*sorted(p for p in out.iterdir() if _ASIDE.fullmatch(p.name)), *([work] if work.exists() else [])]


def remove(path: Path) -> None:
    """Remove a file or a folder with all that is in it; a link goes, not what it leads to."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink()
