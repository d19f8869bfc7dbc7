"""From a scene program to a checked scene and a plan of many scenes: `scenec.compile_program`.

    python examples/02_compile.py OUT    (after 01_ingest.py)

The first program puts a tray on a table and three mugs into the tray. An independent judge checks the scene before it
is written to `OUT/scene`, together with the plan from which 03 draws. The second program contradicts itself: instead of
a scene it gives the lines that conflict, and edits that were compiled.
"""

from __future__ import annotations

import sys
from pathlib import Path

import scenec
import usdio

PROGRAMS = Path(__file__).parent / "scenes"


def main(out: Path) -> None:
    """Write `scene.usda` and `plan.json`; print where objects are, and the conflict of the second program."""
    library, folder = out / "library", out / "scene"
    compiled = scenec.compile_program(PROGRAMS / "tray_of_mugs.yaml", library, seed=1, diversity=1.0)
    print(f"tray_of_mugs: {compiled.report.verdict}")
    (scene,) = compiled.scenes  # one per combination of variants, and this program has no variants
    for placed in scene.objects:
        x_m, y_m, z_m = placed.position_m
        print(f"  {placed.id} on or in {placed.parent} at ({x_m:.3f}, {y_m:.3f}, {z_m:.3f}) m")
    usdio.write_scene(scene, library, folder / "scene.usda")
    assert compiled.plan is not None, "a plan comes with `diversity`"
    (folder / "plan.json").write_text(compiled.plan.model_dump_json(indent=1))
    print(f"  {folder / 'scene.usda'} and {folder / 'plan.json'} are written")

    refused = scenec.compile_program(PROGRAMS / "three_cycle.yaml")
    print(f"three_cycle: {refused.report.verdict}; lines that conflict:")
    for member in refused.report.conflict:
        print(f"  {member.file}:{member.line} {member.path}")
    for suggestion in refused.report.suggestions:
        print(f"  {suggestion.edit}: {'compiles' if suggestion.verified else 'not tried'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
