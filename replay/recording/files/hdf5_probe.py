"""`python -m replay.recording.files.hdf5_probe FILE`: read everything in an HDF5 file once; made to be run in a cell.

Damaged files make libhdf5 run without end, crash or take all memory. What this reads to its end can be read again.
Exit code 1 where libhdf5 refuses, with its message.
"""

from __future__ import annotations

import sys

import h5py

MOST_PACKED_RATIO = 1032  # of deflate (RFC 1951, zlib's technical details)
MOST_UNSTORED_BYTES = 10**9  # that a data set may declare and not write, which read as zeros
ROWS_AT_ONCE = 65536  # of a data set at a time


def main(path: str) -> str | None:
    """None, or the error text of libhdf5."""
    try:
        with h5py.File(path, "r") as file:
            file.visititems(lambda _, item: _read(item))
            _read(file)
    except Exception as error:  # h5py hands on damage as nearly every kind of exception.
        return f"{type(error).__name__}: {error}"
    return None


def _read(item: h5py.Group | h5py.Dataset | h5py.Datatype) -> None:
    for name in item.attrs:
        item.attrs[name]
    if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual or item.shape is None:
        return
    stored = item.id.get_storage_size()
    if item.nbytes > MOST_UNSTORED_BYTES + MOST_PACKED_RATIO * stored:
        raise ValueError(f"'{item.name}' declares {item.nbytes} bytes and stores {stored}")
    if item.ndim == 0:
        item[()]
    for first in range(0, len(item) if item.ndim else 0, ROWS_AT_ONCE):
        item[first : first + ROWS_AT_ONCE]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
