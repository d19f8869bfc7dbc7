"""Linear RGB factor of a sampled lighting on the default lamp and dome of a stage."""

from __future__ import annotations

from pxr import UsdLux

from schemas.scene.samples import SampledLighting
from usdio.write.scene import LAMP_INTENSITY


def light_color(lighting: SampledLighting | None) -> tuple[float, float, float]:
    """Linear RGB factor on lamp and dome from intensity, exposure, and black-body temperature; 1 without a lighting."""
    if lighting is None:
        return (1.0, 1.0, 1.0)
    bright = (lighting.intensity or LAMP_INTENSITY) / LAMP_INTENSITY * 2.0 ** (lighting.exposure or 0.0)
    tint = (1.0, 1.0, 1.0)
    if lighting.temperature_K is not None:
        tint = tuple(UsdLux.BlackbodyTemperatureAsRgb(lighting.temperature_K))
    red, green, blue = (bright * float(channel) for channel in tint)
    return red, green, blue
