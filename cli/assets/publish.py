"""`mana assets publish`: a release folder that may be passed on, and the check of one."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from assetkit.library import catalog
from assetkit.publishing.check_release import check_release
from assetkit.publishing.release_folder import publish_release
from cli import text
from schemas.diagnostics import Diagnostic


def publish_command(
    library: Annotated[Path | None, typer.Argument(help="An output folder of `mana assets ingest`.")] = None,
    ids: Annotated[list[str] | None, typer.Argument(help="Packages of it; all of them where none is named.")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="The release folder.")] = None,
    allow: Annotated[
        list[str] | None,
        typer.Option(help="nc, nd, review, or the text of a licence that you have read. May be repeated."),
    ] = None,
    skip_refused: Annotated[
        bool, typer.Option("--skip-refused", help="Release the others where some assets are refused.")
    ] = False,
    check: Annotated[
        Path | None, typer.Option("--check", help="Instead: compare a release folder with its manifest.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Write a release: the packages, LICENCES/, ATTRIBUTION.md, and manifest.json with the SHA-256 of every file.

    An asset is refused without a licence on record, with one that forbids redistribution, with one whose terms are not
    known, and, unless --allow names it, with one that forbids commercial use (nc) or changed versions (nd), or while it
    awaits a decision (review). Then nothing is written, unless --skip-refused is given. `mana assets review LIBRARY
    ITEM --set license=CC-BY-4.0 --by NAME` puts a licence on record. Exit code 1 when nothing was written or a checked
    file differs, 2 when the command could not run.

    Examples: `mana assets publish library --out release`, `mana assets publish library mug bowl --out release
    --allow nc`, `mana assets publish --check release`
    """
    if check is not None:
        if library is not None or out is not None:
            raise typer.BadParameter("takes the release folder alone", param_hint="--check")
        _check(check, as_json=as_json)
        return
    if library is None or out is None:
        raise typer.BadParameter("needs a library and --out", param_hint="LIBRARY")
    names = ids or [folder.name for folder, _ in catalog.records(library)]
    for name in names:
        if not (library / name).is_dir():
            raise FileNotFoundError(library / name)
    if not names:
        raise FileNotFoundError(f"no package in {library}")
    packages = [library / name for name in dict.fromkeys(names)]
    release = publish_release(packages, out, allowed=frozenset(allow or ()), skip_refused=skip_refused)
    if as_json:
        answer = {"folder": None if release.folder is None else str(release.folder), "assets": release.assets}
        print(json.dumps(answer | {"refused": _rows(release.refused), "warnings": _rows(release.warnings)}, indent=1))
    else:
        for each in (*release.refused, *release.warnings):
            text.show_diagnostic(each)
        state = "nothing was written" if release.folder is None else f"{len(release.assets)} assets in {release.folder}"
        text.console.print(escape(state), soft_wrap=True)
    raise typer.Exit(1 if release.folder is None or (release.refused and not skip_refused) else 0)


def _check(folder: Path, *, as_json: bool) -> None:
    """Print how a release differs from its manifest. Raises typer.Exit."""
    if not folder.is_dir():
        raise FileNotFoundError(folder)
    count, differences = check_release(folder)
    if as_json:
        print(json.dumps({"files": count, "findings": _rows(differences)}, indent=1))
    else:
        for each in differences:
            text.show_diagnostic(each)
        text.console.print(f"{count} files in the manifest, {len(differences)} differences")
    raise typer.Exit(1 if differences else 0)


def _rows(findings: Sequence[Diagnostic]) -> list[dict[str, object]]:
    return [each.model_dump(mode="json") for each in findings]
