"""An exclusive lock on a folder: at most one process at a time writes into it.

The lock is `flock(2)` on the file `.lock` in the folder. The kernel releases it when the holder ends, however it ends,
so the file of a killed process blocks no other. Child processes do not inherit it.
"""

from __future__ import annotations

import fcntl
import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LOCK = ".lock"


class FolderUnusable(Exception):
    """An output folder cannot be made, written into or locked; the text is one line with folder and reason."""


class FolderInUse(FolderUnusable):
    """Another process holds the lock of the folder."""


@contextmanager
def exclusive(folder: Path) -> Iterator[None]:
    """Within it no other process gets the lock of `folder`, which is created when absent. Not reentrant.

    Raises FolderInUse at once when another process holds the lock, and FolderUnusable when no file can be written
    there. The lock file is removed at the end, and with it a folder that was created here and is still empty.
    """
    try:
        created = not folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = _locked_descriptor(folder)
    except (FileExistsError, NotADirectoryError):
        raise FolderUnusable(f"cannot write into '{folder}': it, or a part of its path, is not a folder") from None
    except OSError as error:
        raise FolderUnusable(f"cannot write into '{folder}': {error.strerror}") from None
    try:
        yield
    finally:
        with suppress(OSError):
            (folder / LOCK).unlink()  # Before the lock is released: a process that has opened this file tries again.
            if created:
                folder.rmdir()
        os.close(descriptor)


def _locked_descriptor(folder: Path) -> int:
    """A descriptor of the lock file, with the lock; the file holds the process id and host of the holder."""
    while True:
        descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        try:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                holder = _name_of_holder(os.pread(descriptor, 1024, 0).decode(errors="replace"))
                advice = "wait until that ends, or choose another folder"
                raise FolderInUse(f"the folder '{folder}' is in use by {holder}; {advice}") from None
            if _is_the_file(descriptor, folder / LOCK):
                os.ftruncate(descriptor, 0)
                os.pwrite(descriptor, f"{os.getpid()} {platform.node()}\n".encode(), 0)
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _is_the_file(descriptor: int, path: Path) -> bool:
    """Whether `path` is still the file that was opened: the holder before may have removed it."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _name_of_holder(content: str) -> str:
    pid, _, host = content.strip().partition(" ")
    if not pid:
        return "another process"
    return f"process {pid}" if host == platform.node() else f"process {pid} on {host}"
