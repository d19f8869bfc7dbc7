"""`python -m render WHAT REQUEST.npz`: draw one saved request; run it in a cell.

WHAT names a row of `REQUESTS`. Exit codes: 0 all pictures written; 2 wrong arguments or an unreadable request; 3 no
software OpenGL on this system (the message names the packages). A graphics driver without its back end kills the
process with a signal.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from pkgutil import resolve_name

NO_OPENGL = 3
# Each kind of drawing: the type of its request and the function that draws one, imported when it is needed.
REQUESTS: Mapping[str, tuple[str, str]] = {
    "previews": ("render.request:RenderRequest", "render.views:render_all"),
    "frames": ("render.frames_request:FramesRequest", "render.frames:draw_frames"),
    "mode": ("render.modes.request:ModeRequest", "render.modes.draw:draw_mode"),
    "motion": ("render.motion_request:MotionRequest", "render.joints:draw_motion"),
    "variants": ("render.variants.request:VariantsRequest", "render.variants.draw:draw_variants"),
}


def main(argv: list[str]) -> int:
    """Draw the request at `argv[1]`, of the kind `argv[0]`; returns the exit code."""
    if len(argv) != 2 or argv[0] not in REQUESTS:
        sys.stderr.write(f"usage: python -m render {'|'.join(REQUESTS)} REQUEST.npz\n")
        return 2
    # llvmpipe keeps to one core, since a batch runs a process per core; VTK reads this when it is loaded.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    from render.window import NoOpenGL
    from schemas.files import array_files

    kind, draw = (resolve_name(name) for name in REQUESTS[argv[0]])
    try:
        request = array_files.load(kind, Path(argv[1]))
    except (OSError, ValueError) as error:
        sys.stderr.write(f"cannot read {argv[1]}: {error}\n")
        return 2
    try:
        draw(request)
    except NoOpenGL as error:
        sys.stderr.write(f"{error}\n")
        return NO_OPENGL
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
