"""Makes what was written survive a power cut, and swaps two folders in one step.

A rename is atomic for other processes, yet after a power cut the new name may lead to an empty file unless its bytes
were flushed before (fsync(2), and Pillai et al., "All File Systems Are Not Created Equal", OSDI 2014).
"""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from pathlib import Path

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2  # fcntl.h, linux/fs.h
_UNSUPPORTED = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)  # renameat2(2): an old kernel, or the file system
_LIBC = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


def sync(path: Path) -> None:
    """Flush a file, or the names in a folder, to its disk. Raises OSError, also for what the disk could not take."""
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_tree(folder: Path) -> None:
    """Flush all files of a folder and of those in it, then their names."""
    for parent, _, names in os.walk(folder, topdown=False):
        for name in names:
            sync(Path(parent) / name)
        sync(Path(parent))


def exchange(one: Path, other: Path) -> bool:
    """Swap two folders of one file system in a single step; False where the system cannot, and nothing happened."""
    rename = getattr(_LIBC, "renameat2", None)
    if rename is None:
        return False
    if rename(_AT_FDCWD, os.fsencode(one), _AT_FDCWD, os.fsencode(other), _RENAME_EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in _UNSUPPORTED:
        return False
    raise OSError(number, os.strerror(number), str(other))
