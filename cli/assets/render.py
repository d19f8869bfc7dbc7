"""`mana assets render`: pictures of a file or a package in modes, with contact sheets, or a GIF of moving joints."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, get_args

import typer

from cli import text
from render.modes.request import LARGEST_PX, Mode

MODES: tuple[Mode, ...] = get_args(Mode)
_OF_PACKAGES: frozenset[Mode] = frozenset(("parts", "collision", "physics"))  # what a source file cannot show


def render_command(
    path: Annotated[Path, typer.Argument(help="A source file or a package.", exists=True)],
    out: Annotated[Path, typer.Option("--out", help="Folder of the pictures; with --joints perhaps a .gif.")] = Path(
        "pictures"
    ),
    mode: Annotated[
        list[str] | None,
        typer.Option("--mode", help=f"{', '.join(MODES)} or all; may be repeated. Without it: beauty."),
    ] = None,
    views: Annotated[
        int, typer.Option("--views", min=1, max=36, help="4: the standard ones. Else so many from all around.")
    ] = 4,
    size: Annotated[int, typer.Option("--size", min=64, max=LARGEST_PX, help="Edge of a picture in pixels.")] = 512,
    joints: Annotated[
        bool, typer.Option("--joints", help="A GIF of the moving joints instead: joints.gif, or the file of --out.")
    ] = False,
    joint: Annotated[
        list[str] | None, typer.Option("--joint", help="With --joints: move this one only. May be repeated.")
    ] = None,
    frames: Annotated[
        int, typer.Option("--frames", min=2, max=240, help="With --joints: pictures from one end to the other.")
    ] = 24,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Draw an object from several sides and a contact sheet of these; or a GIF of its moving joints.

    Modes: `beauty` (materials under studio light), `wire` (edges of the mesh) and, of packages, `parts` (a colour for
    each label), `collision` (shapes over the body), `physics` (mass centre, principal axes, box of the same inertia).
    Files are MODE_VIEW.png and the sheet MODE.png. Joints move from the limit nearer to the rest state to the other one
    and back, all together unless --joint names some; joints without limits make one turn, joints that follow others
    move with these. A rigid object is refused (asset/missing-joint).

    Examples: `mana assets render library/mug --mode all --out pictures`, `mana assets render mug.glb --views 8 --size
    1024`, `mana assets render library/microwave --joints --out door.gif`, `mana assets render library/cabinet --joints
    --joint top_drawer --frames 40`
    """
    from assetkit.library.previews import animation, pictures

    modes = _modes(mode or ["beauty"], package=path.is_dir())
    if joints:
        gif = out if out.suffix.lower() == ".gif" else out / "joints.gif"
        written = [animation(path, gif, frames=frames, joints=joint or ())]
    elif joint:
        raise typer.BadParameter("needs --joints", param_hint="--joint")
    else:
        written = pictures(path, out, modes, views=views, size_px=size)
    if as_json:
        print(json.dumps([str(p) for p in written]))
    else:
        text.console.print("\n".join(str(p) for p in written), soft_wrap=True)


def _modes(named: list[str], *, package: bool) -> tuple[Mode, ...]:
    """The modes in the order of the table; `all` are those that the object can show."""
    unknown = sorted(set(named) - {*MODES, "all"})
    if unknown:
        raise typer.BadParameter(f"{unknown[0]!r} is none of {', '.join(MODES)}, all", param_hint="--mode")
    shown: tuple[Mode, ...] = tuple(m for m in MODES if package or m not in _OF_PACKAGES)
    if "all" in named:
        return shown
    chosen: tuple[Mode, ...] = tuple(m for m in MODES if m in named)
    if refused := [m for m in chosen if m not in shown]:
        words = f"{refused[0]} is known of packages only: run `mana assets ingest` first"
        raise typer.BadParameter(words, param_hint="--mode")
    return chosen
