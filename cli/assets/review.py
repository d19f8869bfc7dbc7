"""`mana assets review`: what needs a person, and what persons decided."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, cast, get_args

import typer
from pydantic import ValidationError
from rich.markup import escape

from assetkit.annotate.name_reading import category_by_name
from assetkit.batch.decisions import DECISIONS, check_value, read_decisions, record_decision
from assetkit.batch.report_file import read_items
from assetkit.library.review import ReviewItem, decision_about, items_called, review_items
from cli import text
from schemas.decision import DecidedField, Decision
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

_OF_THE_FILE = {"license", "author", "units", "up_axis"}


def review_command(
    library: Annotated[
        Path, typer.Argument(help="An output folder of `mana assets ingest`.", exists=True, file_okay=False)
    ],
    item: Annotated[str | None, typer.Argument(help="A source, its file name, or a package. None: all.")] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help=f"FIELD=VALUE, several times: {', '.join(get_args(DecidedField))}. Empty withdraws."
        ),
    ] = None,
    part: Annotated[
        list[str] | None,
        typer.Option("--part", help="PART_ID=LABEL, several times; `unlabelled` for none. Empty withdraws."),
    ] = None,
    accept: Annotated[
        bool | None,
        typer.Option("--accept/--no-accept", help="Take the item as it is, with the findings shown; or withdraw that."),
    ] = None,
    by: Annotated[str | None, typer.Option("--by", help="Who decides; needed with --set and --accept.")] = None,
    reason: Annotated[str, typer.Option("--reason", help="Why; kept with the decision.")] = "",
    doubtful: Annotated[
        bool, typer.Option("--doubtful", help="Also released items whose unit, up axis or category is doubtful.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """List what needs a person, with findings, evidence, candidates and pictures; or record a decision on one item.

    A decision is appended to `decisions.jsonl` in the library and changes nothing yet: the next `mana assets ingest`
    makes that one item anew with it. It is bound to the content of the source, so it holds wherever that file comes
    again, and no longer when the file changes. What is set becomes declared evidence; `--accept` covers the findings
    known now, not later ones; the last decision wins, and that is said. No decision is ever removed.

    Exit code 0, also while items wait; 1 when the decisions cannot be read; 2 when the item or the value is not known.

    Examples: `mana assets review library`, `mana assets review library mug.obj`,
    `mana assets review library mug.obj --set category=mug --set units=mm --accept --by Ann --reason "measured it"`,
    `mana assets review library pot.obj --part part_2=lid --by Ann`
    """
    decisions = read_decisions(library)
    deciding = bool(set_) or bool(part) or accept is not None
    if item is None:
        if deciding:
            raise typer.BadParameter("name the item that the decision is about", param_hint="ITEM")
        waiting = (i for i in read_items(library) if doubtful or i.outcome is ItemOutcome.REVIEW)
        asked = [
            q
            for q in review_items(library, waiting, decisions)
            if q.outcome is ItemOutcome.REVIEW or (q.doubts and q.outcome is not ItemOutcome.REJECTED)
        ]
        _show_all(library, asked, as_json)
        return
    meant = _the_one(items_called(read_items(library), item), item)
    if not deciding:
        _show_all(library, list(review_items(library, [meant], decisions)), as_json)
        return
    decision = _decision(library, meant, item, set_ or [], part or [], accept, by, reason)
    record_decision(decision, library)
    if as_json:
        print(decision.model_dump_json(indent=1))
        return
    text.console.print(f"recorded in {escape(str(library / DECISIONS))}", soft_wrap=True)
    _remark_category(decision)
    text.console.print("the next `mana assets ingest` of this source uses it", soft_wrap=True)


def _decision(
    library: Path,
    meant: ReportItem,
    name: str,
    set_: list[str],
    part: list[str],
    accept: bool | None,
    by: str | None,
    reason: str,
) -> Decision:
    if not by or not by.strip():
        raise typer.BadParameter("say who decides", param_hint="--by")
    fields = [_field_and_value(text_) for text_ in set_]
    statements = dict(fields)
    if len(statements) < len(fields):
        raise typer.BadParameter("a field can be set once", param_hint="--set")
    if name in meant.packages and len(meant.packages) > 1 and (whole := _OF_THE_FILE & set(statements)):
        shown = " and ".join(sorted(whole))
        raise typer.BadParameter(
            f"{shown}: the same for all objects of the file; name {meant.source}", param_hint="--set"
        )
    try:
        return decision_about(
            library, meant, name, set_=statements, parts=_part_labels(part), accept=accept, by=by.strip(), reason=reason
        )
    except LookupError as nothing:
        raise typer.BadParameter(str(nothing), param_hint="ITEM") from None
    except ValidationError:
        raise typer.BadParameter("only text in UTF-8 can be kept", param_hint="--by, --reason, --set") from None
    except ValueError as wrong:
        raise typer.BadParameter(str(wrong), param_hint="--part") from None


def _part_labels(said: list[str]) -> dict[str, str]:
    pairs = [text_.partition("=") for text_ in said]
    if any(not equals for _, equals, _ in pairs):
        raise typer.BadParameter("must be PART_ID=LABEL", param_hint="--part")
    labels = {part.strip(): label.strip() for part, _, label in pairs}
    if len(labels) < len(pairs):
        raise typer.BadParameter("a part can be named once", param_hint="--part")
    return labels


def _field_and_value(said: str) -> tuple[DecidedField, str]:
    field, equals, value = (part.strip() for part in said.partition("="))
    field = field.replace("-", "_")
    if not equals or field not in get_args(DecidedField):
        known = ", ".join(get_args(DecidedField))
        raise typer.BadParameter(f"'{said}' is not FIELD=VALUE with one of {known}", param_hint="--set")
    try:
        check_value(field, value)
    except ValueError as wrong:
        raise typer.BadParameter(str(wrong), param_hint="--set") from None
    return cast(DecidedField, field), value


def _the_one(items: list[ReportItem], name: str) -> ReportItem:
    if not items:
        raise typer.BadParameter(f"the report knows no item '{name}'", param_hint="ITEM")
    if len(items) > 1:
        listed = ", ".join(i.source for i in items)
        raise typer.BadParameter(f"'{name}' may be any of {listed}", param_hint="ITEM")
    return items[0]


def _remark_category(decision: Decision) -> None:
    stated = decision.set.get("category")
    if stated and category_by_name(stated) is None:
        text.console.print(
            f"[yellow]'{escape(stated)}' is no category of the vocabulary; it is kept as stated[/yellow]",
            soft_wrap=True,
        )


def _show_all(library: Path, asked: list[ReviewItem], as_json: bool) -> None:
    if as_json:
        print(json.dumps([q.model_dump(mode="json") for q in asked], indent=1))
        return
    for question in asked:
        _show(library, question, causes=len(asked) == 1)
    text.console.print(f"{sum(q.outcome is ItemOutcome.REVIEW for q in asked)} in review, {len(asked)} shown")


def _show(library: Path, question: ReviewItem, *, causes: bool) -> None:
    style = text.STYLE[question.outcome]
    text.console.print(
        f"[{style}]{question.outcome.value}[/{style}] [bold]{escape(question.source)}[/bold]", soft_wrap=True
    )
    for diagnostic in question.findings:
        text.show_diagnostic(diagnostic if causes else diagnostic.model_copy(update={"because": ()}), "  ")
    for doubt in question.doubts:
        _line(f"  {doubt.package}: {doubt.field} is {doubt.value}, {doubt.confidence:.0%} sure ({doubt.evidence})")
        for candidate in doubt.candidates:
            chance = "" if candidate.confidence is None else f" ({candidate.confidence:.0%})"
            _line(f"    --{doubt.flag} {doubt.field}={candidate.value}{chance}: {candidate.means}")
    for picture in question.pictures:
        _line(f"  picture {library / picture}")
    for made in question.decisions:
        verdict = {None: [], True: ["accepted"], False: ["acceptance withdrawn"]}[made.accept]
        named = {part: said.label for part, said in made.parts.items()}
        said = ", ".join([*(f"{field}={value}" for field, value in {**made.set, **named}.items()), *verdict])
        _line(f"  decided by {made.by}: {said}{f' ({made.reason})' if made.reason else ''}")


def _line(line: str) -> None:
    text.console.print(escape(line), soft_wrap=True, highlight=False)
