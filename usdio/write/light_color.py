"""What a drawn lighting makes of the usual lights of a stage."""

# pxr has no type stubs.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from pxr import UsdLux

from schemas.scene.samples import SampledLighting
from usdio.write.scene import LAMP_INTENSITY


def light_color(drawn: SampledLighting | None) -> tuple[float, float, float]:
    """Linear RGB by which it multiplies lamp and dome: intensity, exposure, and the colour of a black body."""
    if drawn is None:
        return (1.0, 1.0, 1.0)
    bright = (drawn.intensity or LAMP_INTENSITY) / LAMP_INTENSITY * 2.0 ** (drawn.exposure or 0.0)
    tint = (1.0, 1.0, 1.0)
    if drawn.temperature_K is not None:
        tint = tuple(UsdLux.BlackbodyTemperatureAsRgb(drawn.temperature_K))
    red, green, blue = (bright * float(channel) for channel in tint)
    return red, green, blue
