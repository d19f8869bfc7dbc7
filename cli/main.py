"""`mana`: one console script; each group of commands lives in a file of its own."""

from __future__ import annotations

import sys
import traceback

import typer

from cli import schema
from cli.assets import app as assets
from cli.demo import app as demo
from cli.gap import app as gap
from cli.plan import app as plan
from cli.replay import app as replay
from cli.scene import app as scene
from jobs.lock import FolderUnusable
from schemas.diagnostics import InvalidInput

app = typer.Typer(
    name="mana",
    help="Turn raw 3D assets into robot-simulation content people can trust.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)
app.add_typer(assets.app, name="assets")
app.add_typer(scene.app, name="scene")
app.add_typer(plan.app, name="plan")
app.add_typer(replay.app, name="replay")
app.add_typer(gap.app, name="gap")
app.add_typer(schema.app, name="schema")
app.command("demo")(demo.demo)


def run() -> None:
    """Run the command line. Exit codes: 0 fine, 1 an error-severity finding, 2 could not run."""
    try:
        app()
    except FileNotFoundError as missing:
        print(f"mana: not found: {missing.filename or missing}", file=sys.stderr)
        raise SystemExit(2) from None
    except FolderUnusable as unusable:
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
