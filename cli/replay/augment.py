"""`mana replay augment`: recordings in, variants with new static objects out."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from cli import text
from cli.cell_answer import ONE_THREAD, ask
from cli.replay.render import camera_names, draw_variants
from jobs.cache import write_atomically
from jobs.cell import Limits
from jobs.schedule import run_all
from jobs.warm import warm_cells
from schemas.diagnostics import Diagnostic

LIMITS = Limits(seconds=3600.0, memory_mb=8192)


def augment_command(
    episodes: Annotated[list[Path], typer.Argument(help="Recordings, or folders of them.", exists=True)],
    out: Annotated[Path, typer.Option("--out", help="Folder for the variants.")],
    plan: Annotated[Path | None, typer.Option(help="Plan whose things are put in.", exists=True)] = None,
    assets: Annotated[Path | None, typer.Option(help="Folder of packages.", exists=True)] = None,
    variants: Annotated[int, typer.Option(min=1, help="Variants of each episode.")] = 10,
    objects: Annotated[int, typer.Option(min=1, help="Objects in each variant.")] = 3,
    seed: Annotated[int, typer.Option(help="Same seed, same variants.")] = 0,
    clearance: Annotated[float, typer.Option(min=0.0, help="Distance kept to all that moves or stands (m).")] = 0.01,
    most_hidden: Annotated[float, typer.Option(help="Largest share of the task objects newly hidden.")] = 1.0,
    support: Annotated[
        list[str] | None, typer.Option(help="Where to put things; default: where objects stood.")
    ] = None,
    meshes: Annotated[Path | None, typer.Option(help="Mesh files that models name.", exists=True)] = None,
    scene: Annotated[Path | None, typer.Option(help="episode.json that says what moved.", exists=True)] = None,
    render: Annotated[bool, typer.Option("--render", help="Draw what the recorded cameras see of each.")] = False,
    cameras: Annotated[str, typer.Option(help="Of --render: names, with commas between; all by default.")] = "",
    every: Annotated[int, typer.Option(min=1, help="Of --render: draw each k-th row of the recording.")] = 1,
    jobs: Annotated[int, typer.Option(min=1, help="Recordings at a time.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Put static objects into recorded episodes, outside the proven swept volume of everything that moves.

    Recorded states and stamps are copied bit for bit. What was finished is not done again. With --render colour, depth
    and instances are in pictures/ of each variant, as `mana replay render` draws them. Exit code 1 when a recording is
    refused.

    Example: `mana replay augment demos/ --assets library/ --out more/ --variants 20 --objects 3`
    """
    given = {
        "out": str(out), "plan": _text(plan), "assets": _text(assets), "meshes": _text(meshes), "scene": _text(scene),
        "supports": support or [],
        "options": {
            "variants": variants, "objects": objects, "seed": seed, "clearance_m": clearance,
            "most_hidden": most_hidden,
            "plan": _text(plan), "assets": _text(assets), "supports": support or [],
        },
    }  # fmt: skip
    rows: list[dict[str, Any]] = []
    refused: list[tuple[Path, Diagnostic]] = []
    with warm_cells("cli.replay.augment_cell", env=ONE_THREAD), text.progress(quiet=as_json) as progress:
        sources = [source for path in episodes for source in recordings_below(path)]
        prefixes = distinct_prefixes(sources)
        task = progress.add_task("augmenting", total=len(sources))
        asked = {source: {**given, "source": str(source), "prefix": prefixes[source]} for source in sources}
        for source, answer in run_all(
            lambda path: ask("cli.replay.augment_cell", asked[path], LIMITS, path.name), sources, jobs=jobs
        ):
            if "refused" in answer:
                refused.append((source, Diagnostic.model_validate(answer["refused"])))
            rows += answer.get("rows", [])
            progress.update(task, advance=1)
    rows.sort(key=lambda row: (row["source"], row["episode"]))
    if render:
        wanted = {"out": str(out), "meshes": _text(meshes), "cameras": camera_names(cameras), "every": every}
        folders = [out / (prefixes[Path(row["source"])] + row["episode"]) for row in rows]
        drawn = draw_variants([v for one in folders for v in sorted(one.glob("variant_*"))], wanted, jobs, as_json)
        for row, folder in zip(rows, folders, strict=True):
            row["frames"] = sum(drawn[v].get("frames", 0) for v in drawn if v.parent == folder)
        refused += [(v, Diagnostic.model_validate(one["refused"])) for v, one in drawn.items() if "refused" in one]
    report = {
        "schema_version": "1.0",
        "episodes": rows,
        "refused": [
            {"source": str(s), "diagnostic": d.model_dump(mode="json")} for s, d in sorted(refused, key=lambda r: r[0])
        ],
    }
    write_atomically(out / "report.json", (json.dumps(report, indent=1) + "\n").encode())
    if as_json:
        print(json.dumps(report, indent=1))
    else:
        _show(rows, refused, out)
    if refused:
        raise typer.Exit(1)


def recordings_below(path: Path) -> Iterator[Path]:
    """The path itself where it is a recording, else the recordings in the folder, in the order of their names."""
    from replay.recording.read import is_recording

    if path.is_file() or is_recording(path):
        yield path
        return
    below = [child for child in sorted(path.iterdir()) if is_recording(child)]
    yield from below or [path]


def distinct_prefixes(sources: Sequence[Path]) -> dict[Path, str]:
    """For recordings that share a name, the folders above them that tell them apart, as a prefix of their output."""
    prefixes = dict.fromkeys(sources, "")
    depth = 0
    while depth < max((len(source.parts) for source in sources), default=0):
        names = Counter(prefixes[source] + source.stem for source in prefixes)
        shared = [source for source in prefixes if names[prefixes[source] + source.stem] > 1]
        if not shared:
            break
        depth += 1
        for source in shared:
            prefixes[source] = "_".join(source.parent.parts[-depth:]).replace("/", "") + "_"
    return prefixes


def _text(path: Path | None) -> str | None:
    return None if path is None else str(path)


def _show(rows: list[dict[str, Any]], refused: list[tuple[Path, Diagnostic]], out: Path) -> None:
    table = [
        {
            "episode": row["episode"],
            "variants": row["variants"],
            "objects": f"{row['objects_inserted']['min']} to {row['objects_requested']}",
            "supports": ", ".join(row["supports"]),
            "frames": row.get("frames", ""),
        }
        for row in rows
    ]
    shown = ("episode", "variants", "objects", "supports", "frames")
    drawn = any("frames" in row for row in rows)
    text.show_rows(table, {name: name for name in shown if drawn or name != "frames"})
    for row in rows:
        for diagnostic in row["diagnostics"][:1]:
            text.show_diagnostic(Diagnostic.model_validate(diagnostic))
    for left_out in dict.fromkeys(package for row in rows for package in row["packages_left_out"]):
        text.console.print(f"left out: {left_out}", markup=False)
    for _, diagnostic in refused:
        text.show_diagnostic(diagnostic)
    text.console.print(f"variants are in {out}; check them with `mana replay verify {out}`", markup=False)
