"""Which sources of a watched folder a pass takes up: those with new or changed files, all of which are settled.

A file is settled when its size and time of writing stayed the same between looks for a while. Folders are looked at,
not subscribed to (inotify): changes that another machine makes on shared storage are announced to nobody, and whether
a copy has ended can be seen from sizes alone.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from assetkit.batch.item_cells import Sources
from assetkit.batch.report_file import FinishedBatch
from assetkit.sources.discover import SourceAsset
from schemas.report import ReportItem


class FileState(NamedTuple):
    """What shows that a file is written to (stat(2))."""

    size_bytes: int
    mtime_ns: int
    inode: int


def files_below(sources: Sequence[Path], out: Path) -> dict[Path, FileState]:
    """The regular files at and below `sources` with their states, without hidden ones and those below `out`."""
    left_out = out.resolve()
    states: dict[Path, FileState] = {}
    waiting = [source.absolute() for source in sources]
    for file in [source for source in waiting if source.is_file()]:
        stat = file.stat()
        states[file] = FileState(stat.st_size, stat.st_mtime_ns, stat.st_ino)
    while waiting:
        try:
            with os.scandir(waiting.pop()) as entries:
                listed = [entry for entry in entries if not entry.name.startswith(".")]
        except (FileNotFoundError, NotADirectoryError):
            continue  # a file, or removed meanwhile
        for entry in listed:
            path = Path(entry.path)
            try:
                if entry.is_dir(follow_symlinks=False):
                    waiting += [] if path.resolve() == left_out else [path]
                elif entry.is_file():
                    stat = entry.stat()
                    states[path] = FileState(stat.st_size, stat.st_mtime_ns, stat.st_ino)
            except FileNotFoundError:
                continue
    return states


@dataclass
class Arrivals:
    """Looks at the files of a watched folder one after another, and which of them wait for a pass.

    `settle_s` is how long a file must have stayed the same. Times are those of one clock that only goes forward.
    """

    settle_s: float
    _since: dict[Path, tuple[FileState, float]] = field(default_factory=dict[Path, tuple[FileState, float]])
    _taken: dict[Path, FileState] = field(default_factory=dict[Path, FileState])
    _unsettled_then: frozenset[Path] = frozenset()
    _now_s: float = 0.0

    def look(self, states: dict[Path, FileState], now_s: float) -> None:
        """Note the states of all files at the time `now_s`."""
        before = self._since
        self._since = {
            path: before[path] if path in before and before[path][0] == state else (state, now_s)
            for path, state in states.items()
        }
        self._now_s = now_s

    def next_pass(self, earlier: FinishedBatch | None) -> PassScope | None:
        """The files that a pass has to take up now, None when nothing has settled since the last one.

        A file that was not settled then and is gone counts as changed: it may have held a source back.
        """
        settled = {path: state for path, (state, since) in self._since.items() if self._now_s - since >= self.settle_s}
        gone = self._unsettled_then - self._since.keys()
        changed = gone | {path for path, state in settled.items() if self._taken.get(path) != state}
        if not changed:
            return None
        return PassScope(frozenset(self._since.keys() - settled.keys()), frozenset(changed), earlier)

    def taken(self, selection: PassScope) -> None:
        """Note that a pass over `selection` has ended: its files wait no more, in the states that were settled."""
        self._unsettled_then = selection.unsettled
        self._taken |= {path: self._since[path][0] for path in selection.changed & self._since.keys()}
        self._taken = {path: state for path, state in self._taken.items() if path in self._since}


@dataclass(frozen=True)
class PassScope:
    """The part of the sources that a pass takes up; items of the others are those of the `earlier` pass.

    A source is held back while its file is `unsettled`, or another file that is no source itself, if no source has a
    deeper root above that. Of the others those count that have `changed` files below their root, or no item yet.
    """

    unsettled: frozenset[Path]
    changed: frozenset[Path]
    earlier: FinishedBatch | None = None

    def split(self, sources: Sources) -> SelectedSources:
        """The sources that are taken up, and the earlier items of the others."""
        files = {_real(source.file.path) for source in sources}
        roots = {source.file.root.resolve() for source in sources}
        waiting = [path for path in map(_real, self.unsettled) if path not in files]
        unsettled = {next((folder for folder in path.parents if folder in roots), None) for path in waiting}
        changed = {folder for path in map(_real, self.changed) if path not in files for folder in path.parents}
        not_settled = {_real(path) for path in self.unsettled}
        arrived = {_real(path) for path in self.changed}
        known = {} if self.earlier is None else {item.source: None for item in self.earlier.items}
        chosen: list[int] = []
        others: dict[str, int] = {}
        for position, source in enumerate(sources):
            path, root = _real(source.file.path), source.file.root.resolve()
            held = path in not_settled or root in unsettled
            new = path in arrived or root in changed or source.given not in known
            if new and not held:
                chosen.append(position)
            elif source.given in known:
                others[source.given] = position
        return SelectedSources(sources, tuple(chosen), others, self.earlier)


@dataclass(frozen=True)
class SelectedSources:
    """Some of `sources`, by their positions; a sized iterable. `others` gives the positions of those with an earlier
    item.
    """

    sources: Sources
    positions: tuple[int, ...]
    others: dict[str, int]
    earlier: FinishedBatch | None

    def __len__(self) -> int:
        return len(self.positions)

    def __iter__(self) -> Iterator[SourceAsset]:
        chosen = set(self.positions)
        return (source for position, source in enumerate(self.sources) if position in chosen)

    def earlier_items(self) -> Iterator[tuple[int, ReportItem]]:
        """The earlier item of each source that is not taken up, with the position of that source."""
        for item in () if self.earlier is None else self.earlier.items:
            if item.source in self.others:
                yield self.others[item.source], item.model_copy(update={"cached": ("item",)})


def _real(path: Path) -> Path:
    """The path with its folder resolved; of a link the name stays."""
    return path.absolute().parent.resolve() / path.name
