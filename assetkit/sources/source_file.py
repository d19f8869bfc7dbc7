"""One source file on disk with the folder that no reference may leave, and the files that references led to."""

from __future__ import annotations

import stat
from dataclasses import dataclass, field
from pathlib import Path

from jobs.cache import file_sha256
from schemas import asset
from schemas.diagnostics import Diagnostic, Location, finding
from schemas.files.references import expected_path, resolve_reference

_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
    stat.S_IFDIR: "a folder",
}


@dataclass(frozen=True)
class SourceFile:
    """The main file of an asset and the folder no reference may leave.

    `visited` and `missing` (paths below the root) log which references were found and which were not; a stored result
    is valid as long as the found ones have not changed and the missing ones have not appeared.
    """

    path: Path
    root: Path
    visited: set[Path] = field(default_factory=set, compare=False, repr=False)
    missing: set[str] = field(default_factory=set, compare=False, repr=False)

    @property
    def relative(self) -> str:
        """The file's path below the root, with forward slashes; used in diagnostics."""
        return self.path.resolve().relative_to(self.root.resolve()).as_posix()

    def resolve(self, uri: str, *, where: Location | None = None, base: Path | None = None) -> Path | None:
        """The file `uri` names, or None when absent; see `schemas.files.references.resolve_reference`."""
        folder = base or self.path.parent
        path = resolve_reference(uri, base=folder, root=self.root, where=where)
        if path is not None:
            self.visited.add(path)
        elif (expected := expected_path(uri, base=folder, root=self.root)) is not None:
            self.missing.add(expected)
        return path

    def folder_names(self) -> tuple[str, ...]:
        """Names of the folders from the file up to its root, nearest first."""
        root, parent = self.root.absolute(), self.path.absolute().parent
        return tuple(f.name for f in (parent, *parent.parents) if f == parent or f.is_relative_to(root))

    def files_read(self) -> tuple[asset.SourceFile, ...]:
        """The main file and every file that a reference led to, by path, with size in bytes and SHA-256."""
        root = self.root.resolve()
        return tuple(
            asset.SourceFile(path=p.relative_to(root).as_posix(), sha256=file_sha256(p), bytes=p.stat().st_size)
            for p in sorted({self.path.resolve(), *self.visited})
        )


def refusal(source: SourceFile) -> Diagnostic | None:
    """Why a source cannot even be opened: it is missing, no regular file, or its path is no text; None when it can."""
    try:
        str(source.path.absolute()).encode()
    except UnicodeEncodeError:
        return finding("asset/parse-error", "the path of the file is not UTF-8 text, which packages need; rename it")
    try:
        mode = source.path.stat().st_mode
    except OSError as error:
        return unreadable(error)
    if not stat.S_ISREG(mode):
        return finding("asset/source-unreadable", f"this is {_KINDS.get(stat.S_IFMT(mode), 'no regular file')}")
    return None


def unreadable(error: OSError, file: str = "the file") -> Diagnostic:
    """Why the operating system does not give `file`: it is not there, or must not or cannot be read."""
    if isinstance(error, FileNotFoundError | NotADirectoryError):
        return finding("asset/source-missing", f"{file} is not there", value=error.strerror)
    return finding("asset/source-unreadable", f"{file} cannot be read: {error.strerror}", value=error.errno)
