"""Damage to the tree of HDF5 files: groups, data sets, types, links, attributes, storage outside of the file."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import h5py
import numpy as np

from tests.suites.fuzz.mutations.raw_bytes import flip_bits

_HUGE = 10**12  # values of a data set that is declared and holds no chunk
_ODD_NUMBERS = (np.nan, np.inf, -np.inf, 1e308, -1.0, 0.0)


def edit_hdf5(rng: Random, data: bytes) -> bytes:
    """One to three changes of the tree; the file is written again by the library."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.hdf5"
        path.write_bytes(data)
        try:
            with h5py.File(path, "r+") as file:
                for _ in range(rng.choice((1, 1, 3))):
                    rng.choice(_EDITS)(rng, file)
        except (OSError, ValueError, RuntimeError, KeyError, TypeError):
            return flip_bits(rng, path.read_bytes() or data)
        return path.read_bytes()


def _members(file: h5py.File, kind: type) -> list[str]:
    names: list[str] = []

    def visit(name: str, item: object) -> None:
        if isinstance(item, kind):
            names.append(name)

    file.visititems(visit)
    return sorted(names) or ["data"]


def _dataset(file: h5py.File, name: str) -> h5py.Dataset:
    item = file[name]
    if not isinstance(item, h5py.Dataset):
        raise KeyError(name)
    return item


def _any_name(rng: Random, file: h5py.File) -> str:
    return rng.choice(_members(file, h5py.Dataset if rng.random() < 0.6 else h5py.Group))


def _delete(rng: Random, file: h5py.File) -> None:
    del file[_any_name(rng, file)]


def _replace(rng: Random, file: h5py.File) -> None:
    """A data set of another type, shape or size."""
    name = rng.choice(_members(file, h5py.Dataset))
    shape = _dataset(file, name).shape
    del file[name]
    values: list[Any] = [
        *(np.zeros(0), np.float64(1.0), np.zeros((3, 0)), np.full(shape, np.nan), np.zeros((*shape, 2))),
        *(
            "text",
            np.array([b"a", b"b"]),
            np.zeros(shape, dtype=complex),
            np.zeros(3, dtype=[("a", "f8")]),
            h5py.Empty("f"),
        ),
        *(
            np.zeros(3, dtype=[("a", "f8")]),
            np.zeros(shape, dtype=">i2"),
            np.zeros(shape, dtype=bool),
            np.full(shape, 1e300),
        ),
    ]
    choice = rng.randrange(len(values) + 3)
    if choice < len(values):
        file[name] = values[choice]
    elif choice == len(values):
        file.create_dataset(name, shape=(_HUGE,), chunks=(1024,), dtype="f8")
    elif choice == len(values) + 1:
        file.create_dataset(name, data=np.zeros(10**6), compression="gzip", chunks=True)
    else:
        file.create_dataset(name, shape=(3,), dtype=h5py.vlen_dtype("f8"))


def _numbers(rng: Random, file: h5py.File) -> None:
    """A few numbers that are not finite or odd; rows in another order."""
    item = _dataset(file, rng.choice(_members(file, h5py.Dataset)))
    values = np.asarray(item[()])
    if values.dtype.kind == "f" and values.size:
        for _ in range(rng.choice((1, 20))):
            values.reshape(-1)[rng.randrange(values.size)] = rng.choice(_ODD_NUMBERS)
        item[...] = values[::-1] if rng.random() < 0.2 else values


def _link(rng: Random, file: h5py.File) -> None:
    """A link to itself, to its parent, to nothing, or to another file."""
    name = _any_name(rng, file)
    del file[name]
    match rng.randrange(6):
        case 0:
            file[name] = h5py.SoftLink("/" + name)
        case 1:
            file[name] = file["/"]
        case 2:
            file[name] = h5py.SoftLink("/absent")
        case 3:
            file[name] = h5py.ExternalLink("../outside/secret.hdf5", "/data")
        case 4:
            file.create_dataset(name, shape=(4,), dtype="f8", external=[("../outside/secret.bin", 0, 64)])
        case _:
            layout = h5py.VirtualLayout(shape=(4,), dtype="f8")
            layout[:] = h5py.VirtualSource("../outside/secret.hdf5", "data", shape=(4,))
            file.create_virtual_dataset(name, layout)


def _attribute(rng: Random, file: h5py.File) -> None:
    """An attribute goes, or becomes another value."""
    items = [i for i in (file[n] for n in (*_members(file, h5py.Group), "/")) if len(i.attrs)]
    if items:
        item = rng.choice(items)
        key = rng.choice(sorted(item.attrs))
        text = str(item.attrs[key])
        del item.attrs[key]
        values: list[Any] = [0, np.nan, "", b"\xff\xfe", "{" * 1000, "[]", np.zeros(3), text[: len(text) // 2], "<a>"]
        choice = rng.randrange(len(values) + 1)
        if choice < len(values):
            item.attrs[key] = values[choice]


def _rename(rng: Random, file: h5py.File) -> None:
    name = _any_name(rng, file)
    file.move(name, rng.choice((name + "é", name + "\x1b[31m", "x", "data/demo_" + "9" * 30, "demo_-1", name + "/a/b")))


def _nest(rng: Random, file: h5py.File) -> None:
    """A thousand groups inside one another."""
    group: h5py.Group = file
    for _ in range(1000):
        group = group.create_group("a")


_EDITS: tuple[Callable[[Random, h5py.File], None], ...] = (
    *(_delete, _replace, _replace, _numbers, _numbers, _link, _link, _attribute, _attribute, _rename, _nest),
)
