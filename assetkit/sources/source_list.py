"""The sources of a batch as a file with one line each: found in a process of its own, read back one after another.

Run as `python -m assetkit.sources.source_list REQUEST.json`, it looks for the sources that the request names and writes
the file. What the search needs in memory grows with the number of files and ends with that process.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from assetkit.sources.discover import SourceAsset, discover
from assetkit.sources.source_file import SourceFile
from jobs.cache import write_atomically
from jobs.cell import Limits, run_cell

SEARCH_LIMITS = Limits(seconds=3600.0, memory_mb=16384)  # the largest collections have some 100,000 files


@dataclass(frozen=True)
class SourceList:
    """The sources in a file, in order; a sized iterable that reads them anew each time."""

    file: Path
    count: int

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[SourceAsset]:
        with self.file.open("rb") as lines:
            for line in lines:
                given, path, root, kind, asset_id = json.loads(line)
                yield SourceAsset(given, SourceFile(_path(path), _path(root)), kind, asset_id)


def listed_sources(sources: Sequence[Path], folder: Path, *, root: Path | None, out: Path) -> SourceList:
    """The sources that `assetkit.sources.discover.discover` finds, in a file below `folder`.

    Raises FileNotFoundError for a path that does not exist, and RuntimeError when the search itself ends early.
    """
    for source in sources:
        if not source.exists():
            raise FileNotFoundError(source)
    folder.mkdir(parents=True, exist_ok=True)
    request, file = folder / "search.json", folder / "sources.jsonl"
    asked = {"sources": [_text(s) for s in sources], "root": None if root is None else _text(root), "out": _text(out)}
    write_atomically(request, json.dumps(asked | {"file": _text(file)}).encode())
    ended = run_cell([sys.executable, "-P", "-m", "assetkit.sources.source_list", str(request)], SEARCH_LIMITS)
    if ended.status == "cancelled":
        raise KeyboardInterrupt
    if ended.status != "ok":
        raise RuntimeError(f"the search for sources ended early ({ended.status}): {ended.output[-500:].strip()}")
    return SourceList(file, int(ended.output.split()[-1]))


def _main(request_file: str) -> None:
    """Search and write the file; prints the number of sources."""
    request = json.loads(Path(request_file).read_text())
    root = None if request["root"] is None else _path(request["root"])
    found = discover([_path(source) for source in request["sources"]], root=root, out=_path(request["out"]))
    rows = ([s.given, _text(s.file.path), _text(s.file.root), s.format, s.asset_id] for s in found)
    file = _path(request["file"])
    with file.open("w", encoding="utf-8") as lines:
        lines.writelines(json.dumps(row) + "\n" for row in rows)
    print(len(found))


def _text(path: Path) -> str:
    """A path as text, byte by byte: names of files need not be UTF-8."""
    return os.fsencode(path).decode("latin-1")


def _path(text: str) -> Path:
    return Path(os.fsdecode(text.encode("latin-1")))


if __name__ == "__main__":
    _main(sys.argv[1])
