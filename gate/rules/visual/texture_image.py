"""Rule: texture files are readable PNG or JPEG images of a supported size."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image, UnidentifiedImageError
from pxr import Ar, Sdf

from gate.rules.rule import Rule
from gate.subject import Subject
from gate.subject.values import TIME, at
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, finding

CODE = DiagnosticCode(
    "asset/gate-texture-image",
    "A texture file is no readable picture",
    "The surface loses its picture.",
    "replace the file named",
)
READABLE = (".png", ".jpg", ".jpeg")
MOST_PIXELS = 16384


def check(subject: Subject) -> Iterator[Diagnostic]:
    """A finding per PNG or JPEG that cannot be read, is cut short, or is larger than graphics cards take."""
    seen: set[str] = set()
    for attribute in subject.attributes:
        value: Any = attribute.Get(TIME) if attribute.GetTypeName() == Sdf.ValueTypeNames.Asset else None
        if value is None:
            continue
        path = value.resolvedPath
        if path in seen or not path.lower().endswith(READABLE) or Ar.IsPackageRelativePath(path):
            continue
        seen.add(path)
        fault = _fault(Path(path))
        if fault:
            yield finding(CODE, f"the texture {fault}", where=at(attribute.GetPrim()), value=value.path)


def _fault(path: Path) -> str:
    """What is wrong with a picture; "" when nothing is. Only the header is decoded, the end is looked at."""
    try:
        with Image.open(path) as image:
            width, height = image.size
            kind = image.format
    except (UnidentifiedImageError, OSError, ValueError, Image.DecompressionBombError):
        return "is no picture"
    if max(width, height) > MOST_PIXELS:
        return f"is {width} x {height} pixels"
    with path.open("rb") as file:
        file.seek(-min(64, path.stat().st_size), 2)
        tail = file.read()
    end = {"PNG": b"IEND", "JPEG": b"\xff\xd9"}.get(kind or "")
    # Some cameras write a few bytes behind the end marker of a JPEG.
    return "is cut short" if end is not None and end not in tail and kind == "PNG" else ""


RULE = Rule(CODE, "a readable PNG or JPEG of at most 16384 pixels a side", "PNG and JPEG specifications", check)
