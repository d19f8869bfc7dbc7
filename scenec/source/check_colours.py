"""Checks colours of inline primitives: CSS names and codes, read as the emitter reads them."""

from __future__ import annotations

from collections.abc import Iterator

from PIL import ImageColor

from scenec.source.listing import written_assets
from schemas.diagnostics import Diagnostic, finding
from schemas.scene.program import BoxAsset, CylinderAsset, SceneProgram, SphereAsset
from source.hint import did_you_mean
from source.tree import Spans, written


def check_colours(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    """A finding (`scene/invalid-value`) for each invalid colour, which would be drawn grey."""
    for path, asset, *_ in written_assets(program):
        if not isinstance(asset, BoxAsset | CylinderAsset | SphereAsset) or asset.color is None:
            continue
        at = (*path, "color")
        try:
            ImageColor.getrgb(asset.color)
        except ValueError:
            hint = did_you_mean(asset.color.lower(), list(ImageColor.colormap))
            headline = f"`{written(at)}` is no colour: a name such as `teal` or a code such as `#2a9d8f`{hint}"
            yield finding("scene/invalid-value", headline, where=spans.place(at), value=asset.color)
