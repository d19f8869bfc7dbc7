"""`python -m render REQUEST.npz`: draw one saved `RenderRequest`; run it in a cell.

Exit codes: 0 all pictures written; 2 wrong arguments or an unreadable request; 3 no software OpenGL on this system (the
message names the packages). A graphics driver without its back end kills the process with a signal.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

NO_OPENGL = 3
T = TypeVar("T")


def main(argv: list[str]) -> int:
    """Draw the request at `argv[0]`; returns the exit code."""
    use_one_thread()
    from render.request import RenderRequest
    from render.views import render_all

    return draw_saved(argv, RenderRequest, render_all)


def use_one_thread() -> None:
    """Limit llvmpipe to one core, since a batch runs a process per core; call before VTK is loaded."""
    os.environ.setdefault("LP_NUM_THREADS", "0")


def draw_saved(argv: list[str], kind: type[T], draw: Callable[[T], object]) -> int:
    """Draw the request of this kind at `argv[0]`; returns the exit code."""
    from render.window import NoOpenGL
    from schemas.files import array_files

    if len(argv) != 1:
        sys.stderr.write("usage: python -m render REQUEST.npz\n")
        return 2
    try:
        request = array_files.load(kind, Path(argv[0]))
    except (OSError, ValueError) as error:
        sys.stderr.write(f"cannot read {argv[0]}: {error}\n")
        return 2
    try:
        draw(request)
    except NoOpenGL as error:
        sys.stderr.write(f"{error}\n")
        return NO_OPENGL
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
