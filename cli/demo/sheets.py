"""Contact sheets of one object of the demo: its looks, its mesh, its colliders, its mass."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from assetkit.library.previews import pictures
from render.modes.request import Mode

SHOWN: tuple[Mode, ...] = ("beauty", "wire", "collision", "physics")
FOLDER = "sheets"
_SIZE_PX = 256
_PREFERRED = "mug"  # an object with a cavity and a handle shows what colliders are worth


@dataclass(frozen=True)
class SheetsDemo:
    """The object, and the sheet of each mode below the demo's folder."""

    name: str
    sheets: tuple[str, ...]


def sheets_demo(library: Path, packages: tuple[str, ...], out: Path) -> SheetsDemo | None:
    """The sheets of one package of the library, the mug where it is there; None without packages."""
    if not packages:
        return None
    name = _PREFERRED if _PREFERRED in packages else packages[0]
    pictures(library / name, out / FOLDER, SHOWN, size_px=_SIZE_PX)
    return SheetsDemo(name, tuple(f"{FOLDER}/{mode}.png" for mode in SHOWN))
