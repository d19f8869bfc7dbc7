"""An outside judge of escapes: the kernel reports whoever opens, lists or changes anything in a watched folder.

Native libraries are seen as well as Python (inotify(7); Linux).
"""

from __future__ import annotations

import ctypes
import os
import struct
from pathlib import Path
from types import TracebackType
from typing import Self

_LIBC = ctypes.CDLL(None, use_errno=True)
# inotify(7): IN_MODIFY, IN_MOVED_FROM, IN_MOVED_TO, IN_CREATE, IN_DELETE, IN_OPEN
_EVENTS = {0x2: "written", 0x40: "moved", 0x80: "moved here", 0x100: "created", 0x200: "deleted", 0x20: "opened"}
_IN_NONBLOCK, _HEADER = 0o4000, struct.Struct("iIII")
_READ_BYTES = 65_536
SECRET = "secret"
SUFFIXES = ("", ".obj", ".mtl", ".png", ".xml", ".urdf", ".usda", ".yaml", ".bin", ".csv", ".stl", ".hdf5", ".dtd")


def make_outside(folder: Path) -> Path:
    """A folder of files that damaged references name; returns it."""
    folder.mkdir(parents=True, exist_ok=True)
    for suffix in SUFFIXES:
        (folder / f"{SECRET}{suffix}").write_bytes(b"#usda 1.0\n" if suffix == ".usda" else b"<a/>\n")
    return folder


class Watch:
    """Within it, `events` lists what happened to the files of a folder since the last call."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._descriptor = folder, -1

    def __enter__(self) -> Self:
        self._descriptor = _LIBC.inotify_init1(_IN_NONBLOCK)
        if (
            self._descriptor < 0
            or _LIBC.inotify_add_watch(self._descriptor, os.fsencode(self._folder), sum(_EVENTS)) < 0
        ):
            raise OSError(ctypes.get_errno(), "inotify cannot watch the folder")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        os.close(self._descriptor)

    def events(self) -> list[str]:
        """What was done to which file, each pair once."""
        events: list[str] = []
        while True:
            try:
                data = os.read(self._descriptor, _READ_BYTES)
            except BlockingIOError:
                return list(dict.fromkeys(events))
            at = 0
            while at < len(data):
                _, mask, _, length = _HEADER.unpack_from(data, at)
                name = data[at + _HEADER.size : at + _HEADER.size + length].rstrip(b"\0").decode(errors="replace")
                events += [f"{word} {name or '(the folder)'}" for bit, word in _EVENTS.items() if mask & bit]
                at += _HEADER.size + length
