"""Save and load frozen dataclasses that hold numpy arrays and bytes: one `.npz`, the same bytes every time."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from schemas.files.zip_damage import ZIP_DAMAGE

T = TypeVar("T")
_TREE = "tree"


def save(value: Any, type_: type[T], path: Path) -> None:
    """Write `value` (an instance of `type_`, a dataclass or pydantic model) to `path`, atomically."""
    arrays: list[np.ndarray] = []
    tree = _detach(adapter(type_).dump_python(value), arrays)
    text = np.frombuffer(json.dumps(tree, sort_keys=True, default=str).encode(), dtype=np.uint8)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    with temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, **{_TREE: text}, **{f"a{i}": a for i, a in enumerate(arrays)})
    temporary.replace(path)


def load(type_: type[T], path: Path) -> T:
    """The value written by `save`. Raises ValueError or OSError when the file is not one."""
    try:
        with np.load(path, allow_pickle=False) as file:
            tree = json.loads(file[_TREE].tobytes())
            return adapter(type_).validate_python(_attach(tree, file))
    except OSError:
        raise
    except (*ZIP_DAMAGE, KeyError) as error:
        raise ValueError(f"{path.name} is damaged: {error}") from error


@cache
def adapter(type_: type[T]) -> TypeAdapter[T]:
    """The converter between values of a type and plain ones; made once, since making it takes longer than using it."""
    return TypeAdapter(type_)


def _detach(tree: Any, arrays: list[np.ndarray]) -> Any:
    """`tree` with arrays and bytes replaced by references into `arrays`, which grows."""
    if isinstance(tree, np.ndarray):
        arrays.append(cast(NDArray[Any], tree))
        return {"$array": len(arrays) - 1}
    if isinstance(tree, bytes):
        arrays.append(np.frombuffer(tree, dtype=np.uint8))
        return {"$bytes": len(arrays) - 1}
    if isinstance(tree, dict):
        return {k: _detach(v, arrays) for k, v in cast(dict[str, Any], tree).items()}
    if isinstance(tree, list | tuple):
        return [_detach(v, arrays) for v in cast(Sequence[Any], tree)]
    return tree


def _attach(tree: Any, file: Any) -> Any:
    if isinstance(tree, dict):
        fields = cast(dict[str, Any], tree)
        if "$array" in fields:
            return file[f"a{fields['$array']}"]
        if "$bytes" in fields:
            return file[f"a{fields['$bytes']}"].tobytes()
        return {k: _attach(v, file) for k, v in fields.items()}
    if isinstance(tree, list):
        return [_attach(v, file) for v in cast(list[Any], tree)]
    return tree
