"""`python -m render.frames_worker REQUEST.npz`: draw one saved `FramesRequest`; run it in a cell.

Exit codes as those of `python -m render`.
"""

from __future__ import annotations

import sys

from render.__main__ import draw_saved, use_one_thread


def main(argv: list[str]) -> int:
    """Draw the request at `argv[0]`; returns the exit code."""
    use_one_thread()
    from render.frames import draw_frames
    from render.frames_request import FramesRequest

    return draw_saved(argv, FramesRequest, draw_frames)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
