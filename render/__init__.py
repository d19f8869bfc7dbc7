"""Pictures of assets and recordings, rendered on the CPU in a child process. Read `views` first."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from render.camera import CameraView
    from render.frames import draw_frames
    from render.views import render_all

__all__ = ["CameraView", "draw_frames", "render_all"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "CameraView": "render.camera",
        "draw_frames": "render.frames",
        "render_all": "render.views",
    },
)
