"""Read numeric columns of Parquet files as float64 arrays, and poses from columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from replay.recording.recorded_numbers import invalid_recording, poses
from schemas.arrays import FloatArray

Columns = dict[str, FloatArray]


def read_columns(path: Path) -> Columns:
    """Every numeric column by name: (n,) float64, or (n, k) for lists of equal length. Raises InvalidInput."""
    try:
        with pq.ParquetFile(path) as file:
            names = [field.name for field in file.schema_arrow if _is_numeric(field.type)]  # No pictures.
            table = file.read(columns=names)
    except FileNotFoundError:
        raise invalid_recording("replay/missing-file", f"'{path.name}' is absent", path.name) from None
    except (pa.ArrowException, OSError) as error:
        raise invalid_recording("replay/unreadable", f"{path.name}: {error}", path.name) from None
    columns = {}
    for name, column in zip(table.column_names, table.columns, strict=True):
        if not _is_list(column.type):
            columns[name] = column.to_numpy().astype(np.float64)
            continue
        widths = set(pc.call_function("list_value_length", [column]).to_pylist())
        if len(widths) == 1 and None not in widths:
            flat = pc.call_function("list_flatten", [column]).to_numpy().astype(np.float64)
            columns[name] = flat.reshape(len(column), -1)
    return columns


def _is_list(kind: pa.DataType) -> bool:
    return pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind)


def _is_numeric(kind: pa.DataType) -> bool:
    kind = kind.value_type if _is_list(kind) else kind
    return pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind)


def column_poses(columns: Columns, name: str, file: str) -> FloatArray:
    """X (n, 4, 4) of the columns `<name>.px ... pz, qw, qx, qy, qz`. Raises InvalidInput."""
    wanted = [f"{name}.{c}" for c in ("px", "py", "pz", "qx", "qy", "qz", "qw")]
    missing = [c for c in wanted if c not in columns]
    if missing:
        raise invalid_recording("replay/missing-column", f"no column '{missing[0]}'", file)
    values = np.stack([columns[c] for c in wanted], axis=1)
    return poses(values[:, :3], values[:, 3:], name, file)
