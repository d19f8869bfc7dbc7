"""`mana replay envelope`: what a recording sweeps, as a picture, a mesh and a ledger."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from cli import text
from jobs.cache import write_atomically

LEDGER, PICTURE, MESH, CAPSULES = "ledger.json", "envelope.png", "envelope.ply", "capsules.npz"
_SHOWN = (
    "body",
    "balls",
    "capsules",
    "protrusion_m",
    "largest_proxy_m",
    "largest_interval_m",
    "largest_simplification_m",
)
_HEADINGS = ("body", "balls", "capsules", "sticks out (mm)", "ball (mm)", "interval (mm)", "simplified (mm)")
_TERMS = ("proxy_m", "gap_m", "interval_m", "simplification_m")


def envelope_command(
    episode: Annotated[Path, typer.Argument(help="A recording.", exists=True)],
    out: Annotated[Path, typer.Option("--out", help="Folder for picture, mesh and ledger.")],
    clearance: Annotated[float, typer.Option(min=0.0, help="Distance kept to all that moves (m).")] = 0.01,
    protrusion: Annotated[float, typer.Option(min=0.001, help="How far balls may stick out of bodies (m).")] = 0.006,
    simplification: Annotated[float, typer.Option(min=0.0, help="How far capsules may cut corners (m).")] = 0.003,
    probes: Annotated[bool, typer.Option(help="Probe intervals as the paper does, for comparison: no proof.")] = False,
    support: Annotated[list[str] | None, typer.Option(help="Supports to draw; default: where objects stood.")] = None,
    meshes: Annotated[Path | None, typer.Option(help="Mesh files that models name.", exists=True)] = None,
    scene: Annotated[Path | None, typer.Option(help="episode.json that says what moved.", exists=True)] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Show the volume that everything that moves stays in, and what each capsule's radius is made of.

    Writes envelope.png, envelope.ply, capsules.npz (every capsule with its terms, body and times) and ledger.json.

    Example: `mana replay envelope demo.hdf5 --out swept/`
    """
    import trimesh

    from cli.replay.picture import picture
    from render.isosurface import zero_surface
    from replay.augmentation import prepare
    from replay.envelope.distance_grid import signed_distance
    from replay.envelope.envelope import Settings
    from replay.envelope.probes import Tolerances
    from replay.recording.formats.read import read_episode

    refinement = Tolerances() if probes else None
    settings = Settings(protrusion, clearance_m=clearance, simplification_m=simplification, probes=refinement)
    prepared = prepare(read_episode(episode, meshes, scene), settings, support or [])
    envelope = prepared.envelope
    rows = [_row(envelope, number) for number in range(len(envelope.bodies))]
    areas = {
        site.free_space.support.name: {
            "area_m2": site.free_space.support.area.area,
            "taken_by": site.free_space.blocked_by(0.1),
        }
        for site in prepared.sites
    }
    report: dict[str, Any] = {
        "schema_version": "1.0",
        "clearance_m": clearance,
        "proved": not probes,
        "bodies": rows,
        "supports": areas,
    }
    if len(envelope.body):
        points, triangles = zero_surface(*signed_distance(envelope, 0.01))
        mesh = trimesh.Trimesh(points, triangles, process=False).export(file_type="ply")
        write_atomically(out / MESH, mesh)  # pyright: ignore[reportArgumentType]
    write_atomically(out / PICTURE, picture(prepared))
    columns = {term: getattr(envelope, term) for term in (*_TERMS, "body", "start_W", "end_W", "t_from_s", "t_to_s")}
    np.savez_compressed(out / CAPSULES, bodies=np.array(envelope.bodies), **columns, allow_pickle=True)
    write_atomically(out / LEDGER, (json.dumps(report, indent=1) + "\n").encode())
    if as_json:
        print(json.dumps(report, indent=1))
        return
    text.show_rows([_millimetres(row) for row in rows], dict(zip(_SHOWN, _HEADINGS, strict=True)))
    text.console.print(f"picture, mesh and ledger are in {out}", markup=False)


def _millimetres(row: dict[str, object]) -> dict[str, object]:
    return {key: f"{1000.0 * value:.1f}" if isinstance(value, float) else value for key, value in row.items()}


def _row(envelope: Any, number: int) -> dict[str, object]:
    mine = envelope.body == number
    cover = envelope.covers[number]
    return {
        "body": envelope.bodies[number],
        "balls": len(cover.radii_m),
        "protrusion_m": cover.protrusion_m,
        "uncovered_m": cover.residual_m,
        "capsules": int(mine.sum()),
        **{f"largest_{term}": float(getattr(envelope, term)[mine].max()) for term in _TERMS},
    }
