"""Text that nests deeper than any scene is refused before the parser of OpenUSD sees it."""

from __future__ import annotations

import pytest

from schemas.diagnostics import InvalidInput, Location
from usdio.read import text_nesting
from usdio.read.text_nesting import MAX_NESTING, require_shallow


@pytest.mark.parametrize("pair", ["{}", "[]", "()"])
def test_the_bound_is_exact_and_counts_over_chunks(pair: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(text_nesting, "_CHUNK_BYTES", 64)
    for levels, too_deep in ((MAX_NESTING, False), (MAX_NESTING + 1, True)):
        data = (f"{pair} " * 100 + pair[0] * levels + pair[1] * levels).encode()
        if too_deep:
            with pytest.raises(InvalidInput) as refused:
                require_shallow(data, Location())
            assert refused.value.diagnostic.code == "asset/resource-limit"
        else:
            require_shallow(data, Location())
    require_shallow(b"", Location())
