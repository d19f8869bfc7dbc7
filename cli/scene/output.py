"""The files of a compiled scene: report, stages, JSON, graph, pictures; nothing of an earlier run stays beside them."""

from __future__ import annotations

import re
from pathlib import Path

from cli.scene.verdicts import in_words
from cli.stage_picture import stage_picture
from jobs.cache import write_atomically
from render.camera import CameraView
from scenec.compile import Compiled
from scenec.ir.problem import Solved
from scenec.pictures.failure import failure
from scenec.pictures.plan import plan
from scenec.plan.document import plan_text
from schemas.scene.compiled import CompileReport
from usdio.write.scene import PACKAGES, copy_package, write_scene

REPORT, SCENE, GRAPH, RUNTIME_PLAN = "report.json", "scene", "graph", "plan.json"
PLAN, PERSPECTIVE, FAILURE = "plan.png", "perspective.png", "failure.png"
_OURS = re.compile(
    rf"({SCENE}(-\d+)?\.(usda|json))|({GRAPH}(-\d+)?\.(dot|json))|{RUNTIME_PLAN}|{PLAN}|{PERSPECTIVE}|{FAILURE}|{REPORT}"
)
_VIEW = CameraView("perspective", -70.0, 34.0)  # Beside the default viewer, who stands at -y.


def write_output(compiled: Compiled, assets: Path | None, out: Path) -> CompileReport:
    """Write stages and JSON of every combination and the plan, or nothing; returns the report that names them.

    The first combination is `scene.usda` and `scene.json`, the others `scene-2` and so on.
    """
    out.mkdir(parents=True, exist_ok=True)
    clear(out)
    stages: dict[frozenset[tuple[str, str]], str] = {}
    for index, scene in enumerate(compiled.scenes):
        stem = SCENE if index == 0 else f"{SCENE}-{index + 1}"
        write_scene(scene, assets, out / f"{stem}.usda")
        write_atomically(out / f"{stem}.json", scene.model_dump_json(indent=1).encode())
        stages[frozenset(scene.combination.items())] = f"{stem}.usda"
    rows = [
        row.model_copy(update={"scene": stages.get(frozenset(row.combination.items()))})
        for row in compiled.report.matrix
    ]
    first = f"{SCENE}.usda" if compiled.scenes else None
    named = None
    if compiled.plan is not None:
        named = RUNTIME_PLAN
        for package in sorted({body.package for body in compiled.plan.bodies if body.package is not None}):
            assert assets is not None, "packages come from a library"
            copy_package(assets / package, out / PACKAGES / package)
        write_atomically(out / named, plan_text(compiled.plan).encode())
    return compiled.report.model_copy(update={"matrix": tuple(rows), "scene": first, "plan": named})


def clear(out: Path) -> None:
    """Remove what an earlier run wrote: a stale scene beside a failure would be a lie.

    By exact names alone, and only beside a report, for the folder may hold files of the user.
    """
    if (out / REPORT).is_file():
        for file in sorted(out.iterdir()):
            if _OURS.fullmatch(file.name):
                file.unlink()


def write_report(report: CompileReport, out: Path) -> None:
    """Write `report.json`."""
    out.mkdir(parents=True, exist_ok=True)
    write_atomically(out / REPORT, report.model_dump_json(indent=1).encode())


def write_graphs(compiled: Compiled, out: Path) -> tuple[Path, ...]:
    """Write the interaction graph of every combination as `graph.dot` and `graph.json`, numbered like the scenes."""
    out.mkdir(parents=True, exist_ok=True)
    written = []
    for index, graph in enumerate(compiled.graphs):
        stem = GRAPH if index == 0 else f"{GRAPH}-{index + 1}"
        for suffix, words in (("dot", graph.dot()), ("json", graph.json())):
            written.append(out / f"{stem}.{suffix}")
            write_atomically(written[-1], words.encode())
    return tuple(written)


def draw_plan(compiled: Compiled, out: Path) -> Path | None:
    """`plan.png` of the first combination seen from above, or `failure.png` with what stands in the way."""
    if compiled.failed is not None:
        problem, result = compiled.problems[compiled.failed], compiled.results[compiled.failed]
        among = in_words(compiled.chosen) if compiled.chosen else ""
        picture, name = failure(problem, result, compiled.conflict, among), FAILURE
    elif compiled.scenes:
        result = compiled.results[0]
        assert isinstance(result, Solved), "every combination has a scene"
        picture, name = plan(compiled.problems[0], result.placements, _title(compiled)), PLAN
    else:
        return None
    out.mkdir(parents=True, exist_ok=True)
    for stale in (PLAN, FAILURE):
        (out / stale).unlink(missing_ok=True)
    write_atomically(out / name, picture)
    return out / name


def _title(compiled: Compiled) -> str:
    scene, count = compiled.problems[0].scene, compiled.report.combinations
    return scene if count < 2 else f"{scene}: the first of {count} combinations"


def draw_perspective(scene_usda: Path) -> Path:
    """`perspective.png` beside a written stage; raises as `stage_picture` does."""
    write_atomically(scene_usda.parent / PERSPECTIVE, stage_picture(scene_usda, _VIEW, 768))
    return scene_usda.parent / PERSPECTIVE
