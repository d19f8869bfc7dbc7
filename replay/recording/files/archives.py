"""Read arrays of `.npz` archives with care: no pickles, and a bound on the unpacked bytes."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from replay.recording.recorded_numbers import invalid_recording
from schemas.arrays import FloatArray
from schemas.files.zip_damage import ZIP_DAMAGE

MAX_ENTRIES, MAX_UNPACKED_BYTES = 20_000, 2**30


def read_arrays(path: Path, is_needed: Callable[[str], bool]) -> dict[str, FloatArray]:
    """The arrays whose key is needed. Raises FileNotFoundError, and InvalidInput for what is damaged or too large."""
    try:
        with zipfile.ZipFile(path) as packed:
            sizes = [entry.file_size for entry in packed.infolist()]
        if len(sizes) > MAX_ENTRIES or sum(sizes) > MAX_UNPACKED_BYTES:
            raise invalid_recording(
                "replay/unreadable", f"{path.name}: {len(sizes)} arrays, {sum(sizes)} bytes", path.name
            )
        with np.load(path, allow_pickle=False) as archive:
            return {key: archive[key] for key in archive.files if is_needed(key)}
    except FileNotFoundError:
        raise
    except ZIP_DAMAGE as error:
        raise invalid_recording("replay/unreadable", f"{path.name}: {error}", path.name) from None
