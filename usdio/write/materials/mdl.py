"""What the MDL materials of NVIDIA's library have in common: their modules, one texture transform, pictures of data.

Sources of the parameters: the tables of OmniPbrMaterial and OmniGlassMaterial in the manual of Isaac Sim, and the page
of OmniPBR ClearCoat in that of Omniverse.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Mapping
from functools import lru_cache

import numpy as np
from PIL import Image
from pxr import UsdShade

from schemas.appearance.material import Texture, TextureUse
from usdio.write.materials.network import IDENTITY_UV, Network, Types, set_file, set_input

MONO_ALPHA, MONO_AVERAGE = 0, 1  # base::mono_mode of MDL: which number a picture of several channels stands for
_GREY_TOLERANCE = 4  # of 255: JPEG stores grey pictures with chroma that rounds off by a few levels
_LOOKED_AT = 256  # pixels a side


def placement_of(uses: Iterable[TextureUse]) -> tuple[object, ...] | None:
    """The placement and UV set that all `uses` share, which is all that an MDL material can have; None if none."""
    placements = {(use.uv_set, use.uv_scale, use.uv_rotation_rad, use.uv_offset) for use in uses}
    return placements.pop() if len(placements) == 1 else None


def is_plain(use: TextureUse) -> bool:
    """Whether the texels are used as they are, repeated; MDL textures of this library do nothing else."""
    return use.scale == 1.0 and use.bias == 0.0 and use.wrap_s == use.wrap_t == "repeat"


def author_placement(shader: UsdShade.Shader, uses: Iterable[TextureUse]) -> None:
    """Author the UV set and transform of the first of `uses`, the same for all textures of the material."""
    use = next(iter(uses), None)
    if use is None:
        return
    if use.uv_set:
        set_input(shader, "uv_space_index", Types.Int, use.uv_set)
    if (use.uv_scale, use.uv_rotation_rad, use.uv_offset) != IDENTITY_UV:
        set_input(shader, "texture_scale", Types.Float2, use.uv_scale)
        set_input(shader, "texture_rotate", Types.Float, math.degrees(use.uv_rotation_rad))
        set_input(shader, "texture_translate", Types.Float2, use.uv_offset)


def author_picture(network: Network, shader: UsdShade.Shader, name: str, use: TextureUse | None, space: str) -> None:
    """Author the file of `use`, if any, read as `space` (sRGB or raw)."""
    if use is not None:
        set_file(shader, name, network.files.paths[use.texture], space)


def single_number(use: TextureUse, images: Mapping[str, Texture]) -> bool:
    """Whether the mean of a texel's channels is the channel that `use` reads: a grey picture."""
    return use.channel != "a" and use.texture in images and _is_grey(images[use.texture])


@lru_cache(maxsize=64)
def _is_grey(texture: Texture) -> bool:
    with Image.open(io.BytesIO(texture.data)) as image:
        if image.mode in ("1", "L", "LA", "I", "I;16", "F"):
            return True
        image.draft("RGB", (_LOOKED_AT, _LOOKED_AT))
        pixels = np.asarray(image.convert("RGB").resize((_LOOKED_AT, _LOOKED_AT), Image.Resampling.NEAREST), int)
    return bool(np.ptp(pixels, axis=2).max() <= _GREY_TOLERANCE)
