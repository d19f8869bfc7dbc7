"""Accessors: typed arrays over buffer views, bounds checked before anything is allocated (glTF 2.0, section 3.6.2)."""

from __future__ import annotations

from typing import Final

import numpy as np

from assetkit.readers.gltf.buffers import MAX_BUFFER_BYTES, Buffers
from assetkit.readers.gltf.json import Json
from schemas.diagnostics import InvalidInput, finding

_COMPONENTS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_DTYPES: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_INDEX_DTYPES: Final = {k: _DTYPES[k] for k in (5121, 5123, 5125)}


class Accessors:
    """The accessors of one document. Returned arrays may be views of the file's bytes: read-only."""

    def __init__(self, document: Json, buffers: Buffers) -> None:
        self._buffers = buffers
        self.described = document.items("accessors")

    def read(self, reference: Json, *types: str) -> np.ndarray:
        """The accessor `reference` (an index) points at, which must be of one of `types`: (count, components).

        Normalised integers come as float32 in 0..1 or -1..1 (3.6.2.2), others in their own type.
        Raises InvalidInput: `asset/schema-error` for a wrong type or index, `asset/accessor-out-of-bounds` when it
        passes the end of its view, `asset/resource-limit` when it means more than 1 GiB of zeros.
        """
        accessor = self.described[reference.as_index(self.described, "accessors")]
        type_ = accessor.require("type").as_string()
        if type_ not in types:
            raise accessor.schema_error(f"'type' is {type_}, expected {' or '.join(types)}")
        return normalised(self._values(accessor, _COMPONENTS[type_]), accessor)

    def read_indices(self, reference: Json) -> np.ndarray:
        """The index accessor `reference` points at: (count,) unsigned. Raises InvalidInput as `read` does."""
        accessor = self.described[reference.as_index(self.described, "accessors")]
        _dtype(accessor, _INDEX_DTYPES)
        return self.read(reference, "SCALAR")[:, 0]

    def _values(self, accessor: Json, components: int) -> np.ndarray:
        dtype = _dtype(accessor, _DTYPES)
        count = accessor.integer("count")
        if accessor.get("bufferView") is not None:
            values = self._elements(accessor, dtype, count, components)
        else:
            values = _zeros(accessor, dtype, count, components)
        sparse = accessor.get("sparse")
        return values if sparse is None else self._with_sparse(sparse, values)

    def _elements(self, described: Json, dtype: np.dtype, count: int, components: int) -> np.ndarray:
        """`count` elements of the view that `described` (an accessor or a sparse part) names."""
        view = self._buffers.view(described.require("bufferView").as_index(self._buffers.views, "bufferViews"))
        offset, size = described.integer("byteOffset", 0), dtype.itemsize * components
        stride = view.stride or size
        end = offset + stride * (count - 1) + size if count else offset
        if end > len(view.data):
            headline = f"{count} elements end at byte {end} of a view of {len(view.data)}"
            raise InvalidInput(
                finding(
                    "asset/accessor-out-of-bounds",
                    headline,
                    where=described.where,
                    value=end,
                    bound=len(view.data),
                    unit="bytes",
                )
            )
        if stride < size:
            raise described.schema_error(f"elements of {size} bytes overlap at a stride of {stride}")
        return np.ndarray((count, components), dtype, view.data, offset, (stride, dtype.itemsize))

    def _with_sparse(self, sparse: Json, base: np.ndarray) -> np.ndarray:
        """`base` with the elements that `sparse` lists replaced (3.6.2.3)."""
        count = sparse.integer("count")
        indices, values = sparse.require("indices"), sparse.require("values")
        rows = self._elements(indices, _dtype(indices, _INDEX_DTYPES), count, 1)[:, 0]
        if count and rows.max() >= len(base):
            headline = f"sparse index {rows.max()} passes the end of {len(base)} elements"
            raise InvalidInput(
                finding(
                    "asset/accessor-out-of-bounds",
                    headline,
                    where=indices.where,
                    value=int(rows.max()),
                    bound=len(base) - 1,
                )
            )
        result = base.copy()
        result[rows] = self._elements(values, base.dtype, count, base.shape[1])
        return result


def normalised(values: np.ndarray, accessor: Json) -> np.ndarray:
    """`values` as float32 fractions if `accessor` is normalised and they are integers (3.6.2.2), else unchanged."""
    if not accessor.boolean("normalized", False) or values.dtype.kind not in "iu":
        return values
    return np.maximum(values.astype(np.float32) / np.float32(np.iinfo(values.dtype).max), np.float32(-1.0))


def _dtype(described: Json, allowed: dict[int, str]) -> np.dtype:
    component = described.require("componentType")
    if component.as_integer() not in allowed:
        raise component.schema_error(f"expected one of {', '.join(map(str, allowed))}")
    return np.dtype(allowed[component.as_integer()])


def _zeros(accessor: Json, dtype: np.dtype, count: int, components: int) -> np.ndarray:
    size = count * components * dtype.itemsize
    if size > MAX_BUFFER_BYTES:
        headline = f"the accessor stands for {size} bytes of zeros"
        raise InvalidInput(
            finding(
                "asset/resource-limit",
                headline,
                where=accessor.where,
                value=size,
                bound=MAX_BUFFER_BYTES,
                unit="bytes",
            )
        )
    return np.zeros((count, components), dtype)
