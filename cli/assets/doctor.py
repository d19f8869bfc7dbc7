"""`mana assets doctor`: is a library whole after a crash?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from assetkit.library.doctor import examine
from cli import text


def doctor_command(
    library: Annotated[Path, typer.Argument(help="An output folder of `mana assets ingest`.", exists=True)],
    check: Annotated[bool, typer.Option("--check", help="Repair nothing.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Check that a library is whole: packages, catalog and notes agree, and nothing half-written lies about.

    What is safe is repaired: files of a process that was killed are removed, a package whose replacement was cut short
    is put back, the catalog is written anew. A damaged package is named and left alone; ingest its source again. Exit
    code 1 when something is left to do, 2 while a batch is at work in the folder.

    Example: `mana assets doctor library`
    """
    examination = examine(library, repair=not check)
    if as_json:
        rows = [
            {**each.model_dump(mode="json"), "repaired": done}
            for each, done in zip(examination.findings, examination.repaired, strict=True)
        ]
        print(
            json.dumps({"packages": examination.packages, "healthy": examination.healthy, "findings": rows}, indent=1)
        )
    else:
        for each, done in zip(examination.findings, examination.repaired, strict=True):
            if done:
                text.console.print(f"repaired: {each.headline}", markup=False, soft_wrap=True)
            else:
                text.show_diagnostic(each)
        left = sum(not done for done in examination.repaired)
        state = "whole" if not left else f"{left} findings are left"
        text.console.print(f"{examination.packages} packages, {state}")
    raise typer.Exit(0 if examination.healthy else 1)
