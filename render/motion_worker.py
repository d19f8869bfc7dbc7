"""`python -m render.motion_worker REQUEST.npz`: draw one saved `MotionRequest`; run it in a cell.

Exit codes as those of `python -m render`.
"""

from __future__ import annotations

import sys

from render.__main__ import draw_saved, use_one_thread


def main(argv: list[str]) -> int:
    """Draw the request at `argv[0]`; returns the exit code."""
    use_one_thread()
    from render.joints import draw_motion
    from render.motion_request import MotionRequest

    return draw_saved(argv, MotionRequest, draw_motion)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
