"""`mana replay`: recorded episodes with new static objects, each proved clear of all that moves."""

from __future__ import annotations

import typer

from cli.replay.augment import augment_command
from cli.replay.envelope import envelope_command
from cli.replay.render import compose_command, render_command
from cli.replay.verify import verify_command

app = typer.Typer(help="Put new static objects into recorded episodes, clear of all that moves.", no_args_is_help=True)
app.command("augment")(augment_command)
app.command("envelope")(envelope_command)
app.command("verify")(verify_command)
app.command("compose")(compose_command)
app.command("render")(render_command)
