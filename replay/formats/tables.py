"""Columns of Parquet files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from replay.recorded import poses, stop
from schemas.model import FloatArray

Columns = dict[str, FloatArray]


def read_columns(path: Path) -> Columns:
    """Every numeric column by name: (n,) float64, or (n, k) for lists of equal length. Raises InvalidInput."""
    try:
        table = pq.read_table(path)
    except FileNotFoundError:
        raise stop("replay/missing-file", f"'{path.name}' is absent", path.name) from None
    except (pa.ArrowException, OSError) as error:
        raise stop("replay/unreadable", f"{path.name}: {error}", path.name) from None
    columns = {}
    for name, column in zip(table.column_names, table.columns, strict=True):
        kind = column.type
        if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) or pa.types.is_large_list(kind):
            rows = column.to_pylist()
            if {len(row) for row in rows if row is not None} and len({len(row or ()) for row in rows}) == 1:
                columns[name] = np.array(rows, dtype=np.float64)
        elif pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind):
            columns[name] = column.to_numpy().astype(np.float64)
    return columns


def column_poses(columns: Columns, name: str, file: str) -> FloatArray:
    """X (n, 4, 4) of the columns `<name>.px ... pz, qw, qx, qy, qz`. Raises InvalidInput."""
    wanted = [f"{name}.{c}" for c in ("px", "py", "pz", "qx", "qy", "qz", "qw")]
    missing = [c for c in wanted if c not in columns]
    if missing:
        raise stop("replay/missing-column", f"no column '{missing[0]}'", file)
    values = np.stack([columns[c] for c in wanted], axis=1)
    return poses(values[:, :3], values[:, 3:], name, file)
