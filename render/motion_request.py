"""Input of the child process that draws an object, rigid or of several links, in motion."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from schemas.arrays import FloatArray
from schemas.model import Model


@dataclass(frozen=True)
class MotionRequest:
    """An object to draw in several poses through one camera: save and draw it as a `RenderRequest`, with
    `python -m render motion`.

    model    canonical.
    motions  (k, 4, 4) by the name of each link that its meshes have: what the motion does to points of the asset frame,
             one picture for each: `000.png` and so on in `out_dir`. They may scale.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    model: Model
    motions: dict[str, FloatArray]
    out_dir: str
    size_px: int = 512
