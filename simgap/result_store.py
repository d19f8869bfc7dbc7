"""Stored results of a sim-gap search: its finished answer, and the parts of a run that was interrupted."""

from __future__ import annotations

import io
import json
import pickle
import shutil
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from jobs.cache import Cache, content_key, file_sha256, write_atomically

T = TypeVar("T")
FOLDER = ".cache"
_ANSWER = "answer.json"
# What a stored part may refer to: our own values, and arrays. A file from elsewhere cannot name anything else.
_OURS = ("schemas.", "sim.", "simgap.")
_THEIRS = {
    ("numpy", "ndarray"),
    ("numpy", "dtype"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}


@dataclass(frozen=True)
class ResultStore:
    """The store below an output folder; `key` is a hash of measurement, options and code."""

    out: Path
    key: str

    def part(self, name: str, make: Callable[[], T]) -> T:
        """What `make` gives, from the store if an earlier run of this key got there. A damaged file is made again."""
        path = self._parts.path("parts", content_key(self.key, name), ".bin")
        try:
            return _Reader(io.BytesIO(zlib.decompress(path.read_bytes()))).load()
        except FileNotFoundError:
            pass
        except Exception:  # Whatever a damaged pickle raises: the work is done again.
            path.unlink(missing_ok=True)
        value = make()
        write_atomically(path, zlib.compress(pickle.dumps(value), 1))
        return value

    def answered(self) -> bool:
        """Whether the output folder holds the whole answer to this key, as it was written."""
        try:
            stored = json.loads((self.out / FOLDER / _ANSWER).read_bytes())
            return stored["key"] == self.key and all(file_sha256(self.out / n) == h for n, h in stored["files"].items())
        except (OSError, ValueError, KeyError, AttributeError):
            return False

    def finish(self, files: Mapping[str, bytes]) -> None:
        """Write the answer's files (names relative to the output folder); the parts are not needed any more."""
        for name, data in files.items():
            write_atomically(self.out / name, data)
        hashes = {name: file_sha256(self.out / name) for name in files}
        write_atomically(self.out / FOLDER / _ANSWER, json.dumps({"key": self.key, "files": hashes}).encode())
        shutil.rmtree(self._parts.folder / "parts", ignore_errors=True)

    @property
    def _parts(self) -> Cache:
        return Cache(self.out / FOLDER)


class _Reader(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        if (module.startswith(_OURS) and "." not in name) or (module, name) in _THEIRS:
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} has no place in a stored part")
