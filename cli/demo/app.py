"""`mana demo`: real objects that the installed packages bring become packages and a scene; a hidden effect is named."""

from __future__ import annotations

import importlib.util
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from assetkit.batch.item_cells import default_jobs
from assetkit.batch.report_file import read_report
from assetkit.batch.run_batch import ingest
from assetkit.options import Options
from cli import text
from cli.assets.app import AsJson, shown_progress
from cli.engines import SIMULATOR
from jobs.placement import Placement
from schemas.diagnostics import Severity

# Real meshes of two formats and a robot description; the mug and the tray must keep their cavity, the torus its hole.
OBJECTS = (
    "duck.obj",
    "objects/mug.obj",
    "tray/tray_textured.obj",
    "torus/torus_textured.obj",
    "kiva_shelf/meshes/pod_lowres.stl",
    "lego/lego.obj",
    "domino/domino.obj",
    "soccerball.obj",
    "bunny.obj",
    "random_urdfs/472/472.obj",
    "r2d2.urdf",  # a mechanism
)


def demo(
    out: Annotated[Path, typer.Option("--out", help="Where the page and packages go.")] = Path("demo_out"),
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Assets at a time.")] = default_jobs(),
    as_json: AsJson = False,
) -> None:
    """Ingest real objects of pybullet_data, validate every package, compile a scene, find a hidden effect, show it all.

    Example: `mana demo --out demo_out`
    """
    from assetkit.library.judge_file import validate_file  # Loads USD, which other commands do not need.
    from assetkit.library.validate import main_usd_files
    from cli.demo.acceptance import acceptance_demo
    from cli.demo.gap import gap_demo
    from cli.demo.gate import spoil_package
    from cli.demo.mechanism import GENERATED, mechanism_demo
    from cli.demo.page import write_page
    from cli.demo.replay import replay_demo
    from cli.demo.scene import scene_demo
    from cli.demo.scene import show as show_scene
    from cli.demo.search import search_demo
    from cli.demo.sheets import sheets_demo
    from cli.demo.task import task_demo

    data = data_folder()
    meshes = [data / name for name in OBJECTS if (data / name).is_file()]
    if not meshes:
        raise FileNotFoundError(data)
    library = out / "library"
    options = Options(license="Zlib", author="Bullet contributors")
    with shown_progress(quiet=as_json) as progress:
        report = ingest(
            meshes, library, engine=SIMULATOR, options=options, root=data, placement=Placement(jobs), progress=progress
        )
    verdicts = {file: validate_file(file) for file in main_usd_files(library)}
    first = next((p for item in report.items for p in item.packages), None)
    spoiled = spoil_package(library / first) if first else ()
    packages = tuple(name for item in report.items for name in item.packages)
    with text.console.status("drawing sheets") if not as_json else nullcontext():
        sheets = sheets_demo(library, packages, out)
    with text.console.status("compiling a scene") if not as_json else nullcontext():
        scene = scene_demo(library, out)
    with text.console.status("opening drawers") if not as_json else nullcontext():
        mechanism = mechanism_demo(out)
    with text.console.status("taking, carrying, opening") if not as_json else nullcontext():
        accepted = acceptance_demo(library, out / GENERATED, out)
    with text.console.status("putting objects into a recording") if not as_json else nullcontext():
        replay = replay_demo(library, data / "franka_panda", out)
    with text.console.status("judging a task") if not as_json else nullcontext():
        tasks = task_demo(library, out)
    with text.console.status("naming a hidden effect") if not as_json else nullcontext():
        gap = gap_demo(out, jobs=jobs, tick=lambda words, done=0, total=None: None)
    page = write_page(
        report, verdicts, spoiled, sheets, search_demo(library), scene, mechanism, accepted, replay, tasks, gap, out
    )
    if as_json:
        print(read_report(library).model_dump_json(indent=1))
    else:
        text.show_summary(report)
        show_scene(scene)
        text.console.print(f"sim gap: {escape(gap.report.verdict.statement)}", soft_wrap=True)
        text.console.print(f"page: {escape(str(page))}", soft_wrap=True)
    failed = any(d.severity is Severity.ERROR for found_ in verdicts.values() for d in found_)
    raise typer.Exit(1 if failed or not verdicts else 0)


def data_folder() -> Path:
    """The data folder of the installed PyBullet. Raises FileNotFoundError when it is not there."""
    spec = importlib.util.find_spec("pybullet_data")
    if spec is None or spec.origin is None:
        raise FileNotFoundError("pybullet_data")
    return Path(spec.origin).parent
