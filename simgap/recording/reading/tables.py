"""Reads one table (`.csv`, `.parquet`, `.npz`) as named float64 arrays; executes nothing, bounds sizes."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from schemas.arrays import FloatArray
from schemas.diagnostics import InvalidInput, Location, finding
from schemas.files.zip_damage import ZIP_DAMAGE

MAX_TABLE_BYTES = 512_000_000  # of one file, and of its arrays when unpacked
SUFFIXES = (".csv", ".parquet", ".npz")


@dataclass(frozen=True)
class Table:
    """Columns by the file's names: (n,) each, or (n, k) where a format holds vectors. `bad_cells` are NaN in them."""

    columns: dict[str, FloatArray]
    bad_cells: int = 0
    first_bad: Location | None = None


def read_table(path: Path, file: str, columns: Collection[str] | None = None) -> Table:
    """The `columns` columns that the file has (all of them if None); `file` is how findings call it.

    A text cell without a number is NaN and counted. Raises InvalidInput (`gap/unreadable-table`, `gap/file-too-large`).
    """
    size = path.stat().st_size
    if size > MAX_TABLE_BYTES:
        raise _too_large(file, size)
    readers: dict[str, Callable[[Path, str, Collection[str] | None], Table]] = {
        ".csv": _csv,
        ".parquet": _parquet,
        ".npz": _npz,
    }
    try:
        return readers[path.suffix.lower()](path, file, columns)
    except InvalidInput:
        raise
    except OSError as error:
        raise unreadable(file, error.strerror or "the file cannot be read") from None
    except (*ZIP_DAMAGE, KeyError, csv.Error) as error:
        raise unreadable(file, str(error).splitlines()[0] if str(error) else type(error).__name__) from None


def unreadable(file: str, why: str, line: int | None = None) -> InvalidInput:
    """The finding that ends the reading of one file."""
    return InvalidInput(finding("gap/unreadable-table", why, where=Location(file=file, line=line)))


def _too_large(file: str, size: int) -> InvalidInput:
    where = Location(file=file)
    return InvalidInput(
        finding(
            "gap/file-too-large",
            f"{file} holds {size} bytes",
            where=where,
            value=size,
            bound=MAX_TABLE_BYTES,
            unit="bytes",
        )
    )


def _csv(path: Path, file: str, columns: Collection[str] | None) -> Table:
    """Text with one header row; separator `,`, `;` or tab; lines that begin with `#` are comments."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise unreadable(file, "the text is not UTF-8") from None
    skipped = 0
    for line in text.splitlines()[:100]:
        if line.strip() and not line.lstrip().startswith("#"):
            break
        skipped += 1
    lines = text.splitlines()[skipped:]
    if not lines:
        raise unreadable(file, "the file is empty")
    separator = max(",;\t", key=lines[0].count)
    names = [name.strip().strip('"') for name in lines[0].split(separator)]
    if len(set(names)) < len(names):
        twice = next(n for n in names if names.count(n) > 1)
        raise unreadable(file, f"two columns are called '{twice}'", skipped + 1)
    if all(_number(name) is not None for name in names):
        raise unreadable(file, "the first row holds numbers, not column names", skipped + 1)
    column_numbers = [i for i, name in enumerate(names) if columns is None or name in columns]
    body = lines[1:]
    if not column_numbers or not any(line.strip() for line in body):
        return Table({names[i]: np.empty(0) for i in column_numbers})
    if separator != "," and not any("." in line for line in body):
        body = [line.replace(",", ".") for line in body]  # The spreadsheet of a country with decimal commas.
    try:
        values = np.loadtxt(body, delimiter=separator, usecols=column_numbers, ndmin=2)
        return Table({names[i]: values[:, k] for k, i in enumerate(column_numbers)})
    except (ValueError, IndexError):
        return _tolerant_csv(body, file, names, column_numbers, separator, skipped + 2)


def _tolerant_csv(
    body: list[str], file: str, names: list[str], column_numbers: list[int], separator: str, first_line: int
) -> Table:
    """Cell by cell: blanks and words become NaN; a word is counted as a bad cell, a blank is just missing."""
    rows: list[list[float]] = []
    bad, first = 0, None
    for number, cells in enumerate(csv.reader(io.StringIO("\n".join(body)), delimiter=separator), first_line):
        if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
            continue
        row: list[float] = []
        for i in column_numbers:
            cell = cells[i].strip() if i < len(cells) else "(row too short)"
            value = np.nan if cell == "" else _number(cell)
            if value is None:
                bad, first = bad + 1, first or Location(file=file, line=number, column=i + 1)
            row.append(np.nan if value is None else value)
        rows.append(row)
    values = np.array(rows).reshape(-1, len(column_numbers))
    for k, i in enumerate(column_numbers):
        if len(values) and not np.isfinite(values[:, k]).any() and bad >= len(values):
            raise unreadable(file, f"column '{names[i]}' holds no number", first_line)
    return Table({names[i]: values[:, k] for k, i in enumerate(column_numbers)}, bad, first)


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _parquet(path: Path, file: str, columns: Collection[str] | None) -> Table:
    import pyarrow as pa  # Slow to import, and most folders hold CSV.
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as source:
            groups = source.metadata
            size = sum(groups.row_group(i).total_byte_size for i in range(groups.num_row_groups))
            names = [n for n in source.schema_arrow.names if columns is None or n in columns]
            if max(size, 8 * groups.num_rows * len(names)) > MAX_TABLE_BYTES:
                raise _too_large(file, size)
            table = source.read(columns=names, use_threads=False)
        return Table({name: _arrow_floats(table.column(name).combine_chunks(), name) for name in names})
    except pa.ArrowException as error:
        raise unreadable(file, str(error).splitlines()[0]) from None


def _arrow_floats(column: object, name: str) -> FloatArray:
    """(n,) of a numeric column, (n, k) of a list column whose rows are equally long; nulls are NaN."""
    values = column.to_numpy(zero_copy_only=False)  # pyright: ignore[reportAttributeAccessIssue]
    if values.dtype.kind in "mM":  # Stamps of a clock become seconds.
        return values.astype(f"{values.dtype.kind}8[ns]").astype(np.int64) * 1e-9
    if values.dtype != object:
        return _floats(values, name)
    if all(v is None or np.isscalar(v) for v in values):
        return values.astype(np.float64)
    if len({np.shape(v) for v in values}) > 1:
        raise ValueError(f"rows of column '{name}' differ in length")
    return _floats(np.stack(list(values)), name)


def _npz(path: Path, file: str, columns: Collection[str] | None) -> Table:
    with zipfile.ZipFile(path) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    if size > MAX_TABLE_BYTES:
        raise _too_large(file, size)
    with np.load(path, allow_pickle=False) as arrays:
        names = [name for name in arrays.files if columns is None or name in columns]
        return Table({name: _floats(arrays[name], name) for name in names})


def _floats(values: FloatArray, name: str) -> FloatArray:
    if values.dtype.kind not in "fiub":
        raise ValueError(f"column '{name}' holds {values.dtype}, not numbers")
    return np.atleast_1d(values).astype(np.float64)
