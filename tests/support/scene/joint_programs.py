"""Programs with articulated objects for tests of scenes: drawers, an oven whose door swings, and how they compile."""

from __future__ import annotations

from pathlib import Path

from scenec.bind.asset_library import AssetLibrary
from scenec.compile import Compiled, compile_program

FLOOR = "background: {asset: {type: box, size_m: [1.8, 1.4, 0.05]}}\n"
CUBE = "{type: box, size_m: [0.06, 0.06, 0.05]}"
DRAWERS = FLOOR + (
    "anchors: {floor: {object: background}, low: {object: unit, volume: drawer_1/inside},"
    " high: {object: unit, volume: drawer_2/inside}}\n"
    "objects: [{id: unit, asset: drawer_unit}, {id: cube, asset: %s}]\n"
    "layout:\n  nodes:\n"
    "    unit: {object: unit, joints: {%s}, placement: {type: surface, surface: floor, ranges: {yaw_deg: [-40, 40]}}}\n"
    "    a: {object: cube, placement: {type: volume, volume: low}}\n"
    "    b: {object: cube, placement: {type: volume, volume: high}}\n"
)
OVEN = FLOOR.replace("1.8, 1.4", "1.3, 1.1") + (
    "anchors: {floor: {object: background}, plate: {object: oven, surface: plate/top}}\n"
    "objects: [{id: oven, asset: microwave}, {id: dish, asset: {type: cylinder, radius_m: 0.03, height_m: 0.05}},\n"
    "  {id: box, asset: {type: box, size_m: [0.16, 0.1, 0.1]}}]\n"
    "layout:\n  nodes:\n"
    "    oven: {object: oven, joints: {turn: 0.4}, placement: {type: surface, surface: floor}}\n"
    "    dish: {object: dish, placement: {type: surface, surface: plate}}\n"
    "    box: {object: box}\n"
    "  groups: {rest: {type: scatter, members: [box], surface: floor, count: 4}}\n"
)
CLEAR = "keep_clear: [{object: oven, joint: door}]\n"


def compiled(text: str, folder: Path, library: AssetLibrary, **options: object) -> Compiled:
    """The program of that text, compiled in a folder."""
    file = folder / "program.yaml"
    file.write_text(text)
    return compile_program(file, library=library, **options)  # pyright: ignore[reportArgumentType]
