"""From a scene program to a checked scene and a plan of many scenes: `scenec.compile_program`.

    python examples/02_compile.py OUT    (after 01_ingest.py)

The program places a tray anywhere on a table and three mugs inside it. Either every relation holds in the result, or
the report proves that there is no such scene and names the lines that conflict: a second program contradicts itself.
Writes the stage and the plan to `OUT/scene`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import scenec
import usdio

PROGRAMS = Path(__file__).parent / "scenes"


def main(out: Path) -> None:
    """Compile a program to USD and a plan; print poses, then the conflict of a program without a scene."""
    library, folder = out / "library", out / "scene"
    compiled = scenec.compile_program(PROGRAMS / "tray_of_mugs.yaml", library, seed=1, diversity=1.0)
    print(f"tray_of_mugs: {compiled.report.verdict}")
    stage = usdio.write_scene(compiled.scenes[0], library, folder / "scene.usda")
    for placed in compiled.scenes[0].objects:
        print(f"  {placed}")
    assert compiled.plan is not None, "`diversity` asks for one"
    (folder / "plan.json").write_text(compiled.plan.model_dump_json(indent=1))
    cases = sum(len(pool.cases) for one in compiled.plan.combinations for pool in one.pools)
    print(f"  {stage.name}, and plan.json with {cases} cases")

    refused = scenec.compile_program(PROGRAMS / "three_cycle.yaml", library)
    print(f"three_cycle: {refused.report.verdict}, minimal conflict: {refused.report.minimal}")
    for member in refused.report.conflict:
        print(f"  {member.file}:{member.line}: {member.path}")
    for suggestion in refused.report.suggestions:
        print(f"  {'compiled with' if suggestion.verified else 'not tried'}: {suggestion.edit}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
