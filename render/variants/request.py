"""Input of the child process that draws variants: one model, its sets of materials, the surfaces to distinguish."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import ConfigDict

from render.camera import STANDARD_VIEWS, CameraView
from schemas.appearance.material import Material
from schemas.model import Model

VARIANT_PX = 96  # A surface of a hundredth of the picture still has 90 pixels.


@dataclass(frozen=True)
class VariantsRequest:
    """A model to draw once per set of materials: `python -m render variants REQUEST.npz`.

    model     canonical: metres, z-up, +x is the front.
    variants  sets of materials, each as long as `model.materials`; picture `K_VIEW.png` for each set and view. They
              differ from those of the model in plain values only, not in pictures, emission and alpha mode.
    regions   materials (indices) whose surfaces are distinguished in `regions_VIEW.png`.
    out_dir   an existing folder.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    model: Model
    variants: tuple[tuple[Material, ...], ...]
    regions: tuple[int, ...]
    out_dir: str
    size_px: int = VARIANT_PX
    views: tuple[CameraView, ...] = STANDARD_VIEWS
