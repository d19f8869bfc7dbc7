"""`mana setup`: programs that Mana calls, and that are too large to come with it."""

from __future__ import annotations

import json
from contextlib import nullcontext
from typing import Annotated

import typer
from rich.markup import escape

from assetkit.blender import environment
from cli import text

app = typer.Typer(help="Install programs that Mana calls: Blender, for .blend files.", no_args_is_help=True)
AsJson = Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")]


@app.command("blender")
def blender_command(
    check: Annotated[bool, typer.Option("--check", help="Say whether it is there; install nothing.")] = False,
    as_json: AsJson = False,
) -> None:
    """Install Blender 5.0.1 (`bpy`) into an environment of its own, for reading .blend files.

    It is downloaded from the package index that pip is configured for: 370 MB, 970 MB installed, below
    ~/.local/share/mana (XDG_DATA_HOME), or in the folder that MANA_BLENDER names. An interrupted installation is
    completed by the same command. Exit code 1 when it is not there or cannot be installed.

    Examples: `mana setup blender`, `mana setup blender --check`
    """
    reason = ""
    if not check:
        try:
            with text.console.status("installing Blender, some minutes") if not as_json else nullcontext():
                environment.install()
        except environment.InstallationFailed as failed:
            reason = str(failed)
    ready = environment.python() is not None
    if as_json:
        print(json.dumps({"folder": str(environment.folder()), "ready": ready, "reason": reason}, indent=1))
    elif ready:
        text.console.print(f"Blender is in {escape(str(environment.folder()))}", soft_wrap=True)
    else:
        why = reason or "it is not installed"
        text.console.print(f"Blender is not ready: {escape(why)}", soft_wrap=True)
    raise typer.Exit(0 if ready else 1)


@app.callback()
def setup() -> None:
    """The help of the group is that of `app`."""
