"""The scene of the demo: a program over the packages just made compiles; one that contradicts itself is refused."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.markup import escape

from cli import source_text, text
from cli.demo.plan import PlanDemo, plan_demo
from cli.scene.output import draw_perspective, draw_plan, write_output, write_report
from cli.scene.settle import settle
from jobs.cache import write_atomically
from scenec.compile import compile_program
from schemas.diagnostics import Severity
from schemas.scene.compiled import CompileReport

_TABLE = """\
scene: breakfast
background: {asset: {type: box, size_m: [1.2, 0.8, 0.04], color: "#d9c7a8"}}
anchors:
  tabletop: {object: background, surface: auto}
  inside: {object: tray, volume: auto}
objects:
  - {id: tray, asset: {type: fixed, id: tray_textured}, scale: 0.85, role: receptacle}
  - {id: mug, asset: {type: fixed, id: mug}, semantic_tags: [pickable]}
  - {id: duck, asset: {type: fixed, id: duck}}
  - {id: plate, asset: {type: cylinder, radius_m: 0.12, height_m: 0.02, mass_kg: 0.5, color: "#f5f5f0"}}
layout:
  nodes:
    tray: {object: tray, placement: {type: surface, surface: tabletop, ranges: {yaw_deg: [-15, 15]}}}
    mug_a: {object: mug, placement: {type: volume, volume: inside}}
    mug_b: {object: mug, placement: {type: volume, volume: inside}}
    duck: {object: duck, placement: {type: surface, surface: tabletop}}
    plate: {object: plate, placement: {type: surface, surface: tabletop, ranges: {y: [-0.25, -0.1]}}}
relations:
  - {left_of: [plate, tray], gap: 0.03}
  - {behind: [duck, plate], gap: 0.05}
variants:
  materials:
    - {id: oak, objects: [background], base_color: [0.55, 0.4, 0.25], roughness: 0.7,
       static_friction: 0.5, dynamic_friction: 0.45}
    - {id: steel, objects: [plate], pair: stainless_steel}
    - {id: clay, objects: [plate], pair: terracotta}
"""
_MORE = "  - {left_of: [tray, duck]}\n  - {left_of: [duck, plate], gap: 0.02}\n"


@dataclass(frozen=True)
class SceneDemo:
    """What became of both programs, the refusal in `words`; pictures lie in `folder`, beside the page."""

    folder: str
    compiled: CompileReport
    refused: CompileReport
    words: str
    drawn: PlanDemo | None


def scene_demo(library: Path, out: Path) -> SceneDemo | None:
    """Write programs, stages, reports and pictures to `out/scene`; None when packages that they need are not there."""
    if not all((library / name / "record.json").is_file() for name in ("tray_textured", "mug", "duck")):
        return None
    folder = out / "scene"
    good, bad = folder / "breakfast.yaml", folder / "refused" / "breakfast.yaml"
    write_atomically(good, _TABLE.encode())
    write_atomically(bad, _TABLE.replace("variants:", _MORE + "variants:").encode())
    compiled = compile_program(good, library, diversity=0.5)
    report = write_output(compiled, library, folder)
    draw_plan(compiled, folder)
    if report.scene is not None:
        stage = folder / report.scene
        report = report.model_copy(update={"settling": settle(stage)})
        draw_perspective(stage)
    write_report(report, folder)
    drawn = None if report.plan is None else plan_demo(folder / report.plan)
    failed = compile_program(bad, library)
    draw_plan(failed, bad.parent)
    write_report(failed.report, bad.parent)
    errors = [d for d in failed.report.diagnostics if d.severity is Severity.ERROR]
    return SceneDemo(folder.name, report, failed.report, source_text.plain(errors, bad.parent), drawn)


def show(demo: SceneDemo | None) -> None:
    """One line for the terminal."""
    if demo is not None:
        stay = sum(row.stayed for row in demo.compiled.settling)
        said = f"scene: {demo.compiled.verdict}, {stay} of {len(demo.compiled.settling)} objects stay when let go"
        if demo.drawn is not None:
            said += f"; {demo.drawn.judged} scenes drawn from its plan, {demo.drawn.invalid} invalid"
        text.console.print(escape(said), soft_wrap=True)
