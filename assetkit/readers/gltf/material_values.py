"""Reads the values of one glTF material from its JSON, and notes the origin of each by field of the material."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from assetkit.readers.common.corners import Notes, repaired
from assetkit.readers.gltf.json import Json
from assetkit.readers.gltf.textures import Textures
from schemas.appearance.material import Channel, LinearRGB, Origin, TextureUse
from schemas.diagnostics import finding
from schemas.evidence import BY_STANDARD


class MaterialValues:
    """The values of one material. `origins` holds that of every field that was read, `notes` what was wrong.

    `lost` are the fields whose picture could not be had.

    A property that the file leaves out has the value of the standard, which is sure only by half: exporters leave out
    what they do not know.
    """

    def __init__(self, textures: Textures) -> None:
        self._textures = textures
        self.origins: dict[str, Origin] = {}
        self.notes = Notes()
        self.lost: list[str] = []

    def fraction(self, json: Json, key: str, default: float, field: str) -> float:
        """A number in 0..1; one outside is limited, with a finding."""
        member = self.state(json, key, field)
        return default if member is None else self._clamped(member, member.as_number())

    def number(self, json: Json, key: str, default: float, field: str) -> float:
        """A number without bounds."""
        self.state(json, key, field)
        return json.number(key, default)

    def color(self, json: Json, key: str, default: Sequence[float], field: str) -> LinearRGB:
        """A linear colour, each channel in 0..1."""
        return rgb(self.fractions(json, key, default, field))

    def fractions(self, json: Json, key: str, default: Sequence[float], field: str) -> tuple[float, ...]:
        """Numbers in 0..1, as many as the default has."""
        self.state(json, key, field)
        values = json.vector(key, tuple(default))
        return tuple(self._clamped(json.require(key), v) if not 0.0 <= v <= 1.0 else v for v in values)

    def use(
        self, json: Json, key: str, field: str, channel: Channel = "rgb", *, scale: float = 1.0, bias: float = 0.0
    ) -> TextureUse | None:
        """How a textureInfo object samples its picture; None without one, or when the picture cannot be had."""
        info = json.get(key)
        sampled = self._textures.use(info, channel, scale=scale, bias=bias)
        if sampled is None:
            self.lost += [] if info is None else [field]
            return None
        self.declare(field, _path(json, key))
        return sampled[0]

    def state(self, json: Json, key: str, field: str) -> Json | None:
        """The member of that name, if it is there; the origin of `field` is noted either way."""
        member = json.get(key)
        if member is None:
            self.origins[field] = Origin("declared", f"{_path(json, key)} left out: default of glTF 2.0", BY_STANDARD)
        else:
            self.declare(field, _path(json, key))
        return member

    def declare(self, field: str, method: str) -> None:
        """Note that the file states `field` by the property `method`."""
        self.origins[field] = Origin("declared", method)

    def infer(self, field: str, method: str, confidence: float) -> None:
        """Note that `field` was converted from other properties."""
        self.origins[field] = Origin("inferred", method, confidence)

    def _clamped(self, json: Json, value: float) -> float:
        """`value` limited to 0..1, with a note when that changes it."""
        limited = min(max(value, 0.0), 1.0)
        if limited != value:
            diagnostic = finding(
                "asset/invalid-material-value",
                f"'{json.key}' is outside 0..1",
                where=json.where,
                value=value,
                bound=limited,
            )
            self.notes += repaired(diagnostic, "clamp_material_value", value=value)
        return limited


def rgb(values: Sequence[Any]) -> LinearRGB:
    """Three numbers as a colour."""
    r, g, b = values
    return r, g, b


def _path(json: Json, key: str) -> str:
    """The property within its material: the name of the object that holds it, and its own."""
    return f"{json.key}.{key}" if json.key and not json.key.isdigit() else key
