"""Write a measurement folder, and read the packed arrays that the converters start from."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from ruamel.yaml import YAML

from schemas.measurement import MeasurementSpec

Columns = Mapping[str, np.ndarray]
BLOCKS = 4  # train, test, train, test


class Part(NamedTuple):
    """One measurement of a source: its name below the output folder (empty: the folder itself) and what it holds."""

    name: str
    spec: dict[str, Any]
    tables: Mapping[str, Columns]
    files: Mapping[str, str] = {}


def run(parts: Callable[[Path], Sequence[Part]]) -> None:
    """The command line of a converter: SOURCE_FOLDER OUT_FOLDER, and the name of one part if only that is wanted.

    Several parts become folders in OUT_FOLDER, one part OUT_FOLDER itself.
    """
    if len(sys.argv) not in (3, 4):
        print(f"usage: python -m {parts.__module__} SOURCE_FOLDER OUT_FOLDER [PART]", file=sys.stderr)
        raise SystemExit(2)
    source, out = Path(sys.argv[1]), Path(sys.argv[2])
    made = parts(source)
    wanted = sys.argv[3] if len(sys.argv) == 4 else None
    names = [part.name for part in made]
    if wanted is not None and wanted not in names:
        print(f"no part '{wanted}' in {source}; there are: {', '.join(names)}", file=sys.stderr)
        raise SystemExit(2)
    for part in made:
        if wanted in (None, part.name):
            folder = out / part.name if len(made) > 1 and wanted is None else out
            write(folder, part)
            print(f"{folder}: {len(part.tables)} tables")


def write(folder: Path, part: Part) -> None:
    """The measurement folder; an earlier one at the same place is replaced, anything else there raises FileExistsError.

    The spec is validated first, so a converter cannot write what the reader refuses.
    """
    spec = MeasurementSpec.model_validate(part.spec).model_dump(mode="json", exclude_unset=True)
    if folder.exists():
        if any(folder.iterdir()) and not (folder / "measurement.yaml").is_file():
            raise FileExistsError(f"{folder} holds something else than a measurement")
        shutil.rmtree(folder)
    (folder / "trajectories").mkdir(parents=True)
    yaml = YAML()
    yaml.default_flow_style = None
    yaml.width = 110
    with (folder / "measurement.yaml").open("w") as file:
        yaml.dump(spec, file)
    for name, columns in part.tables.items():
        values = np.column_stack(list(columns.values()))
        path = folder / "trajectories" / f"{name}.csv"
        np.savetxt(path, values, fmt="%.10g", delimiter=",", header=",".join(columns), comments="")
    for name, text in part.files.items():
        (folder / name).write_text(text)


def packed(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    """Trial id and rows (n, k) of an archive with `ids`, `start`, `length` and `data` under one another."""
    with np.load(path) as archive:
        ids, starts, lengths, data = (archive[name] for name in ("ids", "start", "length", "data"))
        for trial_id, start, length in zip(ids, starts, lengths, strict=True):
            yield str(trial_id), data[start : start + length].astype(np.float64)


def named(names: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """Columns (n, k) under names divided by spaces."""
    return dict(zip(names.split(), values.T, strict=True))


def in_blocks(ids: Sequence[str]) -> dict[str, list[str]]:
    """A split that keeps neighbours of one recording together: blocks in turn to train and test."""
    blocks = np.array_split(np.array(ids), min(BLOCKS, len(ids)))
    return {
        "train": [str(i) for block in blocks[0::2] for i in block],
        "test": [str(i) for block in blocks[1::2] for i in block],
    }


def segments(columns: Columns, rows: int) -> dict[str, dict[str, np.ndarray]]:
    """One long log as trials `s00`, `s01` ... of about so many rows each."""
    length = len(next(iter(columns.values())))
    pieces = np.array_split(np.arange(length), max(1, round(length / rows)))
    return {f"s{k:02d}": {name: values[piece] for name, values in columns.items()} for k, piece in enumerate(pieces)}
