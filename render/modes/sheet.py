"""The contact sheet: a title, facts, all views side by side with their names, and a legend."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from PIL import Image, ImageDraw, ImageFont

from render.modes.drawn import Legend

_PAPER, _INK, _PALE = (255, 255, 255), (28, 32, 40), (110, 116, 126)
_MOST_COLUMNS = 4
_GAP_SHARE, _TEXT_SHARE, _TITLE_SHARE = 0.03, 0.032, 0.05  # of the edge of a picture
_LEAST_FONT_PX = 11
_LINE_HEIGHT = 1.4  # heights of a letter from line to line


def contact_sheet(pictures: Mapping[str, Image.Image], title: str, facts: Sequence[str], legend: Legend) -> Image.Image:
    """All pictures (equal in size) in rows of up to four, below the title and facts, above the legend."""
    edge = next(iter(pictures.values())).width
    columns = min(len(pictures), _MOST_COLUMNS)
    rows = math.ceil(len(pictures) / columns)
    gap, text_px = round(_GAP_SHARE * edge), max(round(_TEXT_SHARE * edge), _LEAST_FONT_PX)
    title_px = max(round(_TITLE_SHARE * edge), _LEAST_FONT_PX)
    line, title_line = round(_LINE_HEIGHT * text_px), round(_LINE_HEIGHT * title_px)
    head = gap + (title_line if title else 0) + line * len(facts)
    width, below = gap + columns * (edge + gap), line * len(legend) + (gap if legend else 0)
    sheet = Image.new("RGB", (width, head + gap + rows * (edge + line + gap) + below), _PAPER)
    drawn, font = ImageDraw.Draw(sheet), ImageFont.load_default(text_px)
    y = gap
    if title:
        drawn.text(
            (gap, y), _fitting(title, title_px, width - 2 * gap), fill=_INK, font=ImageFont.load_default(title_px)
        )
        y += title_line
    for fact in facts:
        drawn.text((gap, y), _fitting(fact, text_px, width - 2 * gap), fill=_PALE, font=font)
        y += line
    for number, (name, picture) in enumerate(pictures.items()):
        left = gap + (number % columns) * (edge + gap)
        top = head + gap + (number // columns) * (edge + line + gap)
        sheet.paste(picture.convert("RGB"), (left, top))
        drawn.text((left, top + edge + 2), name.removeprefix("view_"), fill=_PALE, font=font)
    y = head + gap + rows * (edge + line + gap)
    for color, words in legend:
        red, green, blue = (round(255.0 * c) for c in color)
        drawn.rectangle((gap, y + 2, gap + text_px, y + 2 + text_px), fill=(red, green, blue))
        drawn.text(
            (gap + 2 * text_px, y), _fitting(words, text_px, width - 2 * gap - 2 * text_px), fill=_INK, font=font
        )
        y += line
    return sheet


def plain_number(value: float) -> str:
    """Three digits, or all before the point: no powers of ten below a billion."""
    return f"{value:,.0f}" if 100.0 <= abs(value) < 1e9 else f"{value:.3g}"


def _fitting(words: str, font_px: int, width_px: int) -> str:
    """The words without control characters, cut where they would not fit."""
    plain = "".join(c if c.isprintable() else "?" for c in words)
    font = ImageFont.load_default(font_px)
    if font.getlength(plain) <= width_px:
        return plain
    while plain and font.getlength(plain + "...") > width_px:
        plain = plain[:-1]
    return plain + "..."
