"""The mechanism of the demo: a generated drawer unit becomes a package, and things lie in its open drawers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from assetkit.batch.run_batch import ingest
from assetkit.generate.parameters import read_settings
from assetkit.generate.table import GENERATORS
from assetkit.generate.write import write_set
from assetkit.package.record import RECORD
from cli.engines import SIMULATOR
from cli.scene.output import draw_perspective, write_output
from cli.scene.settle import settle
from jobs.cache import write_atomically
from jobs.placement import Placement
from scenec.compile import compile_program
from schemas.asset import AssetRecord
from schemas.scene.compiled import CompileReport

GENERATED = "generated"  # the library of the mechanism, beside the page
_NAME = "drawer_unit"
_SCENE = """\
scene: drawers
background: {asset: {type: box, size_m: [1.4, 1.2, 0.04], color: "#c9c2b4"}}
anchors:
  floor: {object: background, surface: auto}
  lower: {object: unit, volume: drawer_1/inside}
  upper: {object: unit, volume: drawer_2/inside}
  top: {object: unit, surface: auto}
objects:
  - {id: unit, asset: {type: fixed, id: drawer_unit}}
  - {id: cube, asset: {type: box, size_m: [0.06, 0.06, 0.06], color: "#b5482f"}}
  - {id: vase, asset: {type: cylinder, radius_m: 0.05, height_m: 0.2, color: "#5b7f8a"}}
layout:
  nodes:
    unit:
      object: unit
      joints: {drawer_1: 0.22, drawer_2: 0.1}
      placement: {type: surface, surface: floor, ranges: {yaw_deg: [-110, -70]}}
    low: {object: cube, placement: {type: volume, volume: lower}}
    high: {object: cube, placement: {type: volume, volume: upper, ranges: {x: [0.02, 0.1]}}}
    vase: {object: vase, placement: {type: surface, surface: top}}
"""


@dataclass(frozen=True)
class MechanismDemo:
    """The record of the package in `library`, and the scene in `folder`; both lie beside the page."""

    library: str
    folder: str
    record: AssetRecord
    compiled: CompileReport


def mechanism_demo(out: Path) -> MechanismDemo | None:
    """Generate, ingest and place a drawer unit of two levels; None where no package came of it."""
    library, folder = out / GENERATED, out / "drawers"
    generator = GENERATORS[_NAME]
    write_set(generator, read_settings(generator.parameters, ["levels=2"]), library / "sources" / _NAME)
    ingest([library / "sources" / _NAME / f"{_NAME}.urdf"], library, engine=SIMULATOR, placement=Placement(1))
    file = library / _NAME / RECORD
    if not file.is_file():
        return None
    program = folder / "drawers.yaml"
    write_atomically(program, _SCENE.encode())
    compiled = compile_program(program, library)
    report = write_output(compiled, library, folder)
    if report.scene is not None:
        stage = folder / report.scene
        report = report.model_copy(update={"settling": settle(stage)})
        draw_perspective(stage)
    return MechanismDemo(library.name, folder.name, AssetRecord.model_validate_json(file.read_bytes()), report)
