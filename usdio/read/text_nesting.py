"""Bounds how deep text layers nest: the parser of OpenUSD calls itself for each level and overflows its stack."""

from __future__ import annotations

from typing import Final

import numpy as np

from schemas.diagnostics import InvalidInput, Location, finding

# OpenUSD 26.11 ends in a segmentation fault at 40,000 levels of dictionaries with 8 MiB of stack; scenes have tens.
MAX_NESTING: Final = 1000
_CHUNK_BYTES: Final = 1 << 20
_OPENING, _CLOSING = np.frombuffer(b"{[(", dtype=np.uint8), np.frombuffer(b"}])", dtype=np.uint8)


def require_shallow(data: bytes, where: Location) -> None:
    """Raises InvalidInput (`asset/resource-limit`) for more than MAX_NESTING open brackets; those in texts count."""
    level = 0
    for start in range(0, len(data), _CHUNK_BYTES):
        characters = np.frombuffer(data, dtype=np.uint8)[start : start + _CHUNK_BYTES]
        steps = np.isin(characters, _OPENING).astype(np.int64) - np.isin(characters, _CLOSING)
        levels = level + np.cumsum(steps)
        if (deepest := int(levels.max())) > MAX_NESTING:
            headline = "the text nests too deeply"
            raise InvalidInput(
                finding("asset/resource-limit", headline, where=where, value=deepest, bound=MAX_NESTING, unit="levels")
            )
        level = int(levels[-1])
