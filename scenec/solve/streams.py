"""Named random streams: the same seed and words give the same stream in any process, whatever was drawn before."""

from __future__ import annotations

from hashlib import blake2b

import numpy as np


def stream(seed: int, *words: str | int) -> np.random.Generator:
    """A counter-based generator (Philox) keyed by `seed` and `words`, such as a thing's name and a step."""
    text = "\x1f".join([str(seed), *map(str, words)])
    key = int.from_bytes(blake2b(text.encode(), digest_size=16).digest(), "little")
    return np.random.Generator(np.random.Philox(key=key))
