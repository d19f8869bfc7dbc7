"""Classifies an exception while an asset is made: a finding about the source, the storage, or a defect of Mana.

A verdict may be stored only when it follows from the source alone. Files that vanish from the output folder or a full
disk do not depend on the source; `NEVER_STORED` names the codes of such verdicts.
"""

from __future__ import annotations

import errno
import os
import sqlite3
import tempfile
from pathlib import Path

from assetkit.sources.source_file import SourceFile, unreadable
from jobs.cell import CellResult
from schemas.diagnostics import Diagnostic, finding
from schemas.report import ReportItem

NEVER_STORED = frozenset(
    {
        "asset/storage-failed",
        "asset/internal-error",
        "asset/output-occupied",
        "asset/source-missing",
        "asset/source-unreadable",
    }
)
# Errors of a full or failing machine or file system, whichever file it was (errno(3)).
_OF_THE_MACHINE = frozenset(
    {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO, errno.ESTALE, errno.EMFILE, errno.ENFILE, errno.ENOMEM}
    | {errno.EFBIG}
)


def is_storable(item: ReportItem) -> bool:
    """Whether the verdict follows from the source, its options and its limits, not from files of Mana or a defect."""
    return not NEVER_STORED.intersection(item.codes)


def finding_from_exception(error: Exception, source: SourceFile, folders: tuple[Path, ...]) -> Diagnostic:
    """The finding for an unexpected exception: the source cannot be read, the storage failed, or Mana has a defect.

    `folders` are those that Mana writes into; the system's folder for temporary files is one of them.
    """
    if not isinstance(error, OSError):
        return finding("asset/internal-error", f"{type(error).__name__}: {error}")
    path = None if error.filename is None else Path(os.path.abspath(os.fsdecode(error.filename)))
    if path in (Path(os.path.abspath(source.path)), source.path.resolve()):
        return unreadable(error)
    if path in source.visited:
        return unreadable(error, f"'{path.name}', to which the source refers,")
    for folder in (*folders, Path(tempfile.gettempdir())):
        if path is not None and path.is_relative_to(os.path.abspath(folder)):
            return storage_failed(f"{error.strerror}: {path.relative_to(os.path.abspath(folder))}", error.errno)
    if error.errno in _OF_THE_MACHINE:
        return storage_failed(error.strerror or type(error).__name__, error.errno)
    return finding("asset/internal-error", f"{type(error).__name__}: {error}")


def failure_of_folder(error: OSError | sqlite3.OperationalError, folder: Path) -> str | None:
    """Why `folder` takes no more, as a text; None for an error that has another cause."""
    if isinstance(error, sqlite3.OperationalError):
        return str(error)
    path = None if error.filename is None else Path(os.path.abspath(os.fsdecode(error.filename)))
    if error.errno in _OF_THE_MACHINE or (path is not None and path.is_relative_to(os.path.abspath(folder))):
        return error.strerror or type(error).__name__
    return None


def storage_failed(headline: str, number: int | None = None) -> Diagnostic:
    """The finding that a file of Mana's own failed, with the error number of the operating system if there is one."""
    return finding("asset/storage-failed", headline, value=number)


def require_storage(result: CellResult) -> None:
    """Raises OSError when a child process ended with an OSError: its result does not depend on its input."""
    if (reason := result.os_error) is not None:
        raise OSError(errno.EIO, f"a child process failed: {reason}")
