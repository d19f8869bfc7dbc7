"""The option `--scheduler`: where the cells of a command run."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from jobs.placement import Placement

Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        help="Run on a dask cluster: the address of its scheduler, e.g. tcp://host:8786, or local for a cluster of "
        "this machine. Every worker needs this version of Mana and the same folders; docs/how-to/cluster.md.",
    ),
]


def placement_of(jobs: int, scheduler: str | None) -> Placement:
    """Where cells run; lines about workers go to stderr."""
    return Placement(jobs, scheduler, notice=lambda line: print(f"mana: {line}", file=sys.stderr))
