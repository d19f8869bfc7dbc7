"""Reads one output file into values that can be compared: JSON values, arrays by name, pixels, or lines of text.

What differs between runs of equal code is taken out: seconds, versions, cache keys, and hashes over files that hold
those. Absolute paths become placeholders. In JSON Schemas titles go and definitions are numbered.
"""

from __future__ import annotations

import json
import re
import sqlite3
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow.parquet as pq
from PIL import Image

Arrays = dict[str, np.ndarray]
Roots = Mapping[str, str]

TIMES = frozenset({"seconds", "wall_s", "wall_seconds", "envelope_cpu_s", "frames_per_s", "phases", "peak_memory_mb"})
VERSIONS = frozenset({"version", "versions"})
# Digests over files that hold versions: the record of a package (its history has versions and cache keys), and the
# plan, which holds digests of records.
DIGESTS = frozenset({"key", "package_hash", "plan", "restricted_from"})
_DIGEST = re.compile(r"[0-9a-f]{16,64}")
_SPENT = re.compile(r"(?<=\()\d+(\.\d+)? s(?=\))|\d+(\.\d+)? s(?=</div>|</span>|,\s*$)")  # "(0.02 s)"; in report.html
_PICTURES = {".png", ".jpg", ".jpeg"}
_ARRAYS = {".npz", ".npy", ".parquet", ".h5", ".hdf5"}
_USD = {".usdc", ".usd"}
_OPENED = "import sys; from pxr import Sdf; print(Sdf.Layer.FindOrOpen(sys.argv[1]).ExportToString())"
_DEFINITIONS = "#/$defs/"


def read(path: Path, roots: Roots, schema: bool = False) -> object:
    """JSON value, `Arrays`, or list of lines of a file; bytes of what is none of these."""
    suffix = path.suffix.lower()
    if suffix in _PICTURES:
        return {"pixels": pixels(path)}
    if suffix in _ARRAYS:
        return arrays(path)
    if suffix == ".sqlite":
        return without_runs(tables(path))
    if suffix in _USD:
        return lines(usd_text(path), roots)
    try:
        text = path.read_bytes().decode()
    except UnicodeDecodeError:
        return path.read_bytes()
    if suffix == ".json":
        value = json.loads(placed(text, roots))
        return without_names(value) if schema else without_runs(value)
    return lines(text, roots)


def pixels(path: Path) -> np.ndarray:
    """(height, width) or (height, width, channels), as stored; 16 bits stay 16 bits."""
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGBA") if picture.mode == "P" else picture)


def arrays(path: Path) -> Arrays:
    """Every array of an HDF5, Parquet, NPZ or NPY file by name; attributes of HDF5 too."""
    if path.suffix == ".npy":
        return {"": np.load(path)}
    if path.suffix == ".npz":
        with np.load(path) as archive:
            return {name: archive[name] for name in archive.files}
    if path.suffix == ".parquet":
        table = pq.read_table(path)
        return {name: np.array(table[name].to_pylist()) for name in table.column_names}
    found: Arrays = {}

    def keep(name: str, node: h5py.Group | h5py.Dataset) -> None:
        found.update({f"{name}@{key}": np.asarray(value) for key, value in node.attrs.items()})
        if isinstance(node, h5py.Dataset):
            found[name] = np.asarray(node[()])

    with h5py.File(path) as file:
        keep("", file)
        file.visititems(keep)
    return found


def tables(path: Path) -> dict[str, list[list[object]]]:
    """Rows of every table of a database, sorted; tables that only serve its full-text index are left out."""
    connection = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    try:
        listed = connection.execute("select name, sql from sqlite_master where type = 'table'").fetchall()
        indexes = [name for name, sql in listed if "virtual table" in sql.lower()]
        names = sorted(name for name, _ in listed if not any(name.startswith(f"{index}_") for index in indexes))
        rows = {name: connection.execute(f'select * from "{name}"').fetchall() for name in names}
    finally:
        connection.close()
    return {name: sorted((list(map(_unpacked, row)) for row in found), key=repr) for name, found in rows.items()}


def _unpacked(cell: object) -> object:
    try:
        return json.loads(cell) if isinstance(cell, str) and cell[:1] in ("{", "[") else cell
    except json.JSONDecodeError:
        return cell


def usd_text(path: Path) -> str:
    """The layer as text, opened in a child process. Raises CalledProcessError where it cannot be opened."""
    command = [sys.executable, "-c", _OPENED, str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def placed(text: str, roots: Roots) -> str:
    """The text with placeholders for absolute paths; longer paths first."""
    for name, root in sorted(roots.items(), key=lambda item: -len(item[1])):
        text = text.replace(root, f"<{name}>")
    return text


def lines(text: str, roots: Roots) -> list[str]:
    """Lines with placeholders for paths and for seconds that the program took."""
    return [_SPENT.sub("<seconds>", line) for line in placed(text, roots).splitlines()]


def without_runs(value: Any) -> Any:
    """The JSON value without seconds, versions, cache keys and digests over files that hold those."""
    if isinstance(value, list):
        return [without_runs(one) for one in value]
    if not isinstance(value, dict):
        return value
    return {key: without_runs(one) for key, one in value.items() if not _of_a_run(key, one)}


def _of_a_run(key: str, value: object) -> bool:
    if key in DIGESTS:
        return isinstance(value, str) and _DIGEST.fullmatch(value) is not None
    return key in TIMES or key in VERSIONS or key.endswith("_seconds")


def without_names(schema: Any) -> Any:
    """The JSON Schema without titles; definitions are numbered in the order in which references reach them."""
    definitions = schema.get("$defs", {})
    numbers: dict[str, int] = {}

    def reached(reference: str) -> str:
        name = reference.removeprefix(_DEFINITIONS)
        return f"{_DEFINITIONS}{numbers.setdefault(name, len(numbers))}"

    def plain(value: Any, names: bool = False) -> Any:
        """`names`: the keys of `value` are names of properties, not words of JSON Schema."""
        if isinstance(value, list):
            return [plain(one) for one in value]
        if isinstance(value, str):
            return reached(value) if value.startswith(_DEFINITIONS) else value
        if not isinstance(value, dict):
            return value
        kept = {key: one for key, one in sorted(value.items()) if names or key not in ("title", "$defs")}
        return {key: plain(one, not names and key in ("properties", "mapping")) for key, one in kept.items()}

    root = plain(schema)
    numbered: dict[str, Any] = {}
    while len(numbered) < len(numbers):
        name = next(name for name, number in numbers.items() if number == len(numbered))
        numbered[str(len(numbered))] = plain(definitions[name])
    return root | {"$defs": numbered}
