"""`python -m render.variants.worker REQUEST.npz`: draw one saved `VariantsRequest`; run it in a cell."""

from __future__ import annotations

import sys

from render.__main__ import draw_saved, use_one_thread


def main(argv: list[str]) -> int:
    """Draw the request at `argv[0]`; returns the exit code, as `python -m render`."""
    use_one_thread()
    from render.variants.draw import draw_variants
    from render.variants.request import VariantsRequest

    return draw_saved(argv, VariantsRequest, draw_variants)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
