"""`mana plan restrict`: the part of a plan that a task wants, as a plan of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

import typer
from rich.markup import escape

from cli import text
from jobs.cache import write_atomically
from runtime_plan import Restriction, load, restrict


def restrict_command(
    plan: Annotated[Path, typer.Argument(help="`plan.json`, of `mana scene compile`.", exists=True, dir_okay=False)],
    out: Annotated[Path, typer.Option("--out", help="Where the restricted plan goes (JSON).")],
    split: Annotated[
        Literal["train", "eval"] | None, typer.Option("--split", help="Leave out assets named for the other side.")
    ] = None,
    choice: Annotated[
        list[str] | None, typer.Option("--choice", help="KEY=A,B: values that stay, e.g. objects.mug=red_mug.")
    ] = None,
    asset: Annotated[list[str] | None, typer.Option("--asset", help="THING=A,B: assets that a thing may be.")] = None,
    material: Annotated[list[str] | None, typer.Option("--material", help="A paired material that stays.")] = None,
    lighting: Annotated[list[str] | None, typer.Option("--lighting", help="A lighting that stays.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Keep what a task allows: one side of the split, some variants, assets, materials or lightings.

    Layouts are not touched, so every sample stays valid. Samples of the new plan name the new plan; its provenance
    names the one that it was taken from. `mana plan inspect PLAN --json` lists what can be chosen.

    Example: `mana plan restrict out/plan.json --split train --lighting office --out train.json`
    """
    from scenec.plan.document import plan_text

    whole = load(plan)
    restricted = restrict(
        whole,
        Restriction(
            split=split,
            choices=_pairs("--choice", choice),
            assets=_pairs("--asset", asset),
            materials=material,
            lighting=lighting,
        ),
    )
    write_atomically(out, plan_text(restricted.document).encode())
    count = len(restricted.document.combinations)
    if as_json:
        print(json.dumps({"plan": str(out), "restricted_from": whole.sha256, "combinations": count}))
        return
    text.console.print(f"{count} combinations stay, written to {escape(str(out))}")


def _pairs(option: str, values: list[str] | None) -> dict[str, tuple[str, ...]]:
    pairs: dict[str, tuple[str, ...]] = {}
    for value in values or ():
        key, equals, names = value.partition("=")
        if not (key and equals and names):
            raise typer.BadParameter(f"{value!r} is not KEY=A,B", param_hint=option)
        pairs[key] = (*pairs.get(key, ()), *names.split(","))
    return pairs
