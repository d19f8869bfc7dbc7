"""The console script `mana`. Each group of commands lives in a folder of its own, which is imported when it is used."""

from __future__ import annotations

import sys
import traceback
from importlib import import_module
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from jobs.lock import FolderUnusable
from jobs.placement import ClusterUnusable
from schemas.diagnostics import InvalidInput

# Where each command group lives, with its help: `mana --help` shows it and imports no group.
GROUPS = {
    "demo": (
        "cli.demo.app",
        "Ingest real objects of pybullet_data, validate every package, compile a scene, find a hidden effect, "
        "show it all.",
    ),
    "assets": ("cli.assets.app", "Raw asset files in, accepted simulation packages out."),
    "scene": ("cli.scene.app", "Compile scene programs: a whole scene, a proof that there is none, or a limit."),
    "plan": ("cli.plan.app", "Draw scenes from a compiled plan: thousands in a moment, each valid."),
    "replay": ("cli.replay.app", "Put new static objects into recorded episodes, clear of all that moves."),
    "gap": ("cli.gap.app", "Compare a model with recordings and name what it is missing."),
    "task": ("cli.task.app", "Show task graphs, and judge recorded episodes and state logs by them."),
    "pipeline": ("cli.pipeline.app", "Check pipelines before any simulator starts; print their orders."),
    "setup": ("cli.setup", "Install programs that Mana calls: Blender, for .blend files."),
    "schema": ("cli.schema", "Print the JSON Schema of a file Mana reads or writes."),
}
MARKUP = "markdown"


class LazyGroups(TyperGroup):
    """The commands of `GROUPS`; a group's module is imported when one of its commands is resolved."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the groups, in the order of the help page."""
        return list(GROUPS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """A stand-in that holds name and help, enough for the help page."""
        return TyperGroup(name=cmd_name, help=GROUPS[cmd_name][1]) if cmd_name in GROUPS else None

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """The real command, imported now. A name that is none of ours is refused with suggestions."""
        name, command, rest = super().resolve_command(ctx, args)
        return (name, load_group(name), rest) if name in GROUPS else (name, command, rest)


def load_group(name: str) -> Any:
    """The click command of a group: the `app` of its module, or the function of its name for a single command."""
    parent = typer.Typer(rich_markup_mode=MARKUP, pretty_exceptions_enable=False, callback=lambda: None)
    module = import_module(GROUPS[name][0])
    if hasattr(module, "app"):
        parent.add_typer(module.app, name=name)
    else:
        parent.command(name)(getattr(module, name))
    return get_command(parent).commands[name]  # pyright: ignore[reportAttributeAccessIssue]


app = typer.Typer(
    name="mana",
    cls=LazyGroups,
    help="Turn raw 3D assets into robot-simulation content people can trust.",
    no_args_is_help=True,
    rich_markup_mode=MARKUP,
    pretty_exceptions_enable=False,
)


@app.callback()
def mana() -> None:
    """The help of the application is that of `app`."""


def run() -> None:
    """Run the command line. Exit codes: 0 fine, 1 an error-severity finding, 2 could not run."""
    try:
        app()
    except FileNotFoundError as missing:
        print(f"mana: not found: {missing.filename or missing}", file=sys.stderr)
        raise SystemExit(2) from None
    except (FolderUnusable, ClusterUnusable) as unusable:
        print(f"mana: {unusable}", file=sys.stderr)
        raise SystemExit(2) from None
    except InvalidInput as refused:
        print(f"mana: {refused.diagnostic.code}: {refused.diagnostic.headline}", file=sys.stderr)
        raise SystemExit(1) from None
    except Exception:  # A defect of ours; its traceback is the report, and 1 is kept for findings.
        traceback.print_exc()
        raise SystemExit(2) from None


if __name__ == "__main__":
    run()
