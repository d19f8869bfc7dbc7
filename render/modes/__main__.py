"""`python -m render.modes REQUEST.npz`: draw one saved `ModeRequest`; run it in a cell.

Exit codes as those of `python -m render`.
"""

from __future__ import annotations

import sys

from render.__main__ import draw_saved, use_one_thread


def main(argv: list[str]) -> int:
    """Draw the request at `argv[0]`; returns the exit code."""
    use_one_thread()
    from render.modes.draw import draw_mode
    from render.modes.request import ModeRequest

    return draw_saved(argv, ModeRequest, draw_mode)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
