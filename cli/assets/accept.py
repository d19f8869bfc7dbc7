"""`mana assets accept`: run the suites of acceptance on packages, also those of other makers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, cast, get_args

import typer
from rich.markup import escape

from assetkit.batch.suite_rows import suite_rows
from assetkit.library.acceptance_request import GATE, OBJECT, ON_RECORD, AcceptanceReport, AcceptanceRequest
from cli import text
from cli.engines import SIMULATOR
from jobs.cell import Limits
from schemas.acceptance import SuiteSection
from schemas.asset import Role
from schemas.exercised import Exercised

_STYLE = {"passed": "green", "failed": "red", "not run": "dim"}


def accept_command(
    path: Annotated[Path, typer.Argument(help="A USD file, a package or a library.", exists=True)],
    suite: Annotated[
        list[str] | None, typer.Option("--suite", help="Only this suite, whatever the roles. May be repeated.")
    ] = None,
    role: Annotated[
        list[str] | None, typer.Option("--role", help="A role in place of those on record. May be repeated.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="At the values of the package only, not at the ends of their bounds.")
    ] = False,
    video: Annotated[
        Path | None, typer.Option(help="Write a GIF of the gripper at work; for one package.", dir_okay=False)
    ] = None,
    timeout: Annotated[float, typer.Option(help="Seconds one package may take.")] = 300.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Exercise in simulation what the roles of packages promise, on the files as they are.

    The static gate judges the file, the object is set down and dropped, its joints are moved. A gripper takes what is
    to be manipulated, carries it, sets it down; things are put on and into what is to hold them. Suites of roles also
    run with friction and mass at the ends of their bounds: a margin is how far they keep passing. A SimReady USD of
    another maker has no record: name its roles with --role. `docs/explanation/acceptance.md` has all suites with their
    bounds. Exit code 1 when a suite failed, 2 when nothing could be run.

    Examples: `mana assets accept library/mug`, `mana assets accept library --quick --json`,
    `mana assets accept library/microwave --video door.gif`,
    `mana assets accept other/crate.usd --role manipulated --role receptacle`
    """
    from assetkit.acceptance.suites.table import SUITES  # Loads USD, which most commands do not need.
    from assetkit.library.accept import accept_files
    from assetkit.library.validate import main_usd_files

    names = [GATE, OBJECT, ON_RECORD, *(each.name for each in SUITES)]
    for name in suite or ():
        if name not in names:
            raise typer.BadParameter(f"must be one of {', '.join(names)}", param_hint="--suite")
    for name in role or ():
        if name not in get_args(Role):
            raise typer.BadParameter(f"must be one of {', '.join(get_args(Role))}", param_hint="--role")
    files = main_usd_files(path)
    if not files:
        raise FileNotFoundError(f"no USD file in {path}")
    if video is not None and len(files) > 1:
        raise typer.BadParameter(f"{path} has {len(files)} packages; a video shows one", param_hint="--video")
    roles = cast(tuple[Role, ...], tuple(role or ()))
    requests = [
        AcceptanceRequest(
            main_file=str(file.absolute()),
            engine=SIMULATOR,
            suites=tuple(suite or ()),
            roles=roles,
            thorough=not quick,
            video="" if video is None else str(video.absolute()),
        )
        for file in files
    ]
    reports: dict[str, AcceptanceReport] = {}
    for file, report in accept_files(requests, limits=Limits(seconds=timeout)):
        reports[str(file)] = report
        if not as_json:
            _show(file, report, asked=video is not None)
    if as_json:
        print(json.dumps({name: json.loads(report.model_dump_json()) for name, report in reports.items()}, indent=1))
    raise typer.Exit(0 if all(report.passed for report in reports.values()) else 1)


def _show(file: Path, report: AcceptanceReport, *, asked: bool) -> None:
    """The outcome of each suite, what limits it, and findings in full."""
    roles = ", ".join(report.roles) or "no role"
    text.console.print(f"[bold]{escape(str(file))}[/bold]: {roles}", soft_wrap=True)
    show_suites(report.suites)
    for finding in report.findings:
        text.show_diagnostic(finding, "    ")
    if report.video:
        text.console.print(f"  video: {escape(report.video)}", soft_wrap=True)
    elif asked:
        text.console.print("  no video: no suite moved anything with the gripper")


def show_exercised(ranges: Exercised | None) -> None:
    """A line with the ranges of friction and mass over which all suites passed."""
    if ranges is None:
        return
    parts = [
        f"{words} {limit.low:.3g} to {limit.high:.3g}{unit}"
        + (f" (beyond, {', '.join(limit.limited_by)} failed)" if limit.limited_by else "")
        for limit, words, unit in ((ranges.friction, "friction", ""), (ranges.mass_kg, "mass", " kg"))
    ]
    text.console.print(f"  may be varied within {' and '.join(parts)}", soft_wrap=True, markup=False)


def show_suites(suites: Sequence[SuiteSection]) -> None:
    """A line for each suite: outcome, name, checks passed, the first that failed, margins."""
    for row in suite_rows(suites):
        style = _STYLE[row.outcome]
        text.console.print(f"  [{style}]{row.outcome:8}[/{style}] {row.name:14} {escape(row.remark)}", soft_wrap=True)
