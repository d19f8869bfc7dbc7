"""`mana assets search`: find assets by what they are, look like and can do, and see why each one was found."""

from __future__ import annotations

import difflib
import json
from collections.abc import Container, Iterable, Sequence
from pathlib import Path
from typing import Annotated, get_args

import typer
from rich.markup import escape

from assetkit.annotate.name_reading import category_by_name
from assetkit.library import catalog
from assetkit.library.search.limits import limit_of
from assetkit.library.search.match import Match
from assetkit.library.search.parse_query import parse_query
from assetkit.library.search.query import Criterion, Field
from assetkit.library.search.search import Hit, SearchResult
from assetkit.taxonomy.material_classes import materials
from assetkit.taxonomy.tables import categories, families
from cli import text
from schemas.asset import Role
from schemas.outcome import ItemOutcome


def search_command(
    words: Annotated[list[str] | None, typer.Argument(help="[LIBRARY] and what you look for, in English.")] = None,
    library: Annotated[Path | None, typer.Option("--in", help="The library, when it does not stand first.")] = None,
    category: Annotated[str | None, typer.Option(help="Only this category; aliases are understood.")] = None,
    family: Annotated[str | None, typer.Option(help="Only this family, e.g. drinkware.")] = None,
    role: Annotated[str | None, typer.Option(help=f"Only this role: {', '.join(get_args(Role))}.")] = None,
    outcome: Annotated[str | None, typer.Option(help="Only this outcome: accepted, repaired or review.")] = None,
    colour: Annotated[str | None, typer.Option(help="Only with this colour, e.g. red or teal.")] = None,
    material: Annotated[str | None, typer.Option(help="Only of this material, e.g. steel.")] = None,
    has: Annotated[str | None, typer.Option(help="Only with a `surface` to stand on or an `opening`.")] = None,
    min_size: Annotated[str | None, typer.Option("--min-size", help="Least longest edge, e.g. 5cm.")] = None,
    max_size: Annotated[str | None, typer.Option("--max-size", help="Greatest longest edge, e.g. 10cm or 4in.")] = None,
    max_mass: Annotated[str | None, typer.Option("--max-mass", help="Greatest mass, e.g. 500g.")] = None,
    limit: Annotated[int, typer.Option(min=1, help="How many to show.")] = 20,
    as_json: Annotated[bool, typer.Option("--json", help="Print machine-readable JSON and nothing else.")] = False,
) -> None:
    """Find assets of a library by words and filters; each hit says which word matched what, and how sure that is.

    Understood are categories with their aliases ("mug", "frying pan"), families ("drinkware"), roles ("receptacle"),
    colours ("red", "teal": by base colours over the surface), materials ("wooden"), parts ("with a handle"), what one
    can do ("pour from", "put things into", "stand things on"), sizes and masses ("small", "under 10 cm", "at least
    200 g", "12 cm tall"). Any other word is looked for in names, titles, nodes and aliases.

    A hit grants every wish, except that beside a known kind of thing an unknown word or "small" only ranks lower.
    What no asset matches is said; a kind of thing nobody knows never matches everything. Without hits the nearest
    misses are shown.

    Exit code 0 also when nothing is found, 1 when the catalog cannot be read, 2 when there is none or a filter is no
    word of the vocabulary.

    Examples: `mana assets search library "red mug I can pour from"`,
    `mana assets search "tray under 40 cm" --in library --outcome accepted --json`
    """
    folder, request = _library_and_request(words or [], library)
    flags = [
        _category(category, folder),
        _chosen("--family", "family", family, families()),
        _chosen("--role", "role", role, get_args(Role)),
        _chosen("--outcome", "outcome", outcome, [o.value for o in ItemOutcome]),
        _chosen("--material", "material", material, materials()),
        _chosen("--has", "anchor", {"opening": "volume"}.get(has or "", has), ("surface", "volume")),
        _colour(colour),
        _limit("--min-size", "size_m", min_size),
        _limit("--max-size", "size_m", max_size),
        _limit("--max-mass", "mass_kg", max_mass),
    ]
    criteria = (*parse_query(request), *(criterion for criterion in flags if criterion is not None))
    found = catalog.search_catalog(folder, criteria, limit)
    if as_json:
        print(json.dumps(_json(request, found), indent=1))
    else:
        _show(found)


def _library_and_request(words: list[str], library: Path | None) -> tuple[Path, str]:
    """A library may stand first, as in the other commands, or behind `--in`; else it is the current folder."""
    if library is None and words and (Path(words[0]) / catalog.CATALOG).is_file():
        return Path(words[0]), " ".join(words[1:])
    return library or Path("."), " ".join(words)


def _category(name: str | None, folder: Path) -> Criterion | None:
    if name is None:
        return None
    known = category_by_name(name)
    stated = set(catalog.values_of(folder, "category"))  # People may state categories outside the vocabulary.
    aliases = [alias for c in categories().values() for alias in c.aliases]
    value = known.id if known else _one_of("--category", name, [*categories(), *stated], aliases, accepted=stated)
    return Criterion(f"--category {name}", "category", (value,), reading=f"category {value}", is_kind=True, stated=True)


def _chosen(flag: str, field: Field, value: str | None, allowed: Iterable[str]) -> Criterion | None:
    if value is None:
        return None
    listed = list(allowed)
    chosen = _one_of(flag, value, listed, accepted=listed)
    return Criterion(f"{flag} {value}", field, (chosen,), reading=f"{field} {chosen}", stated=True)


def _colour(name: str | None) -> Criterion | None:
    if name is None:
        return None
    from assetkit.materials.colour_names import BASIC_TERMS, colour_by_name  # Loads matplotlib.

    basic = colour_by_name(name.lower()) or _one_of("--colour", name, BASIC_TERMS, accepted=())
    return Criterion(f"--colour {name}", "colour", (basic,), reading=f"colour {basic}", stated=True)


def _limit(flag: str, field: Field, value: str | None) -> Criterion | None:
    if value is None:
        return None
    try:
        figure = limit_of(value, field)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=flag) from None
    low, high = (figure, float("inf")) if flag.startswith("--min") else (0.0, figure)
    return Criterion(
        f"{flag} {value}", field, low=low, high=high, reading=f"{field} {low:.4g} to {high:.4g}", stated=True
    )


def _one_of(
    flag: str, value: str, known: Iterable[str], aliases: Sequence[str] = (), *, accepted: Container[str]
) -> str:
    """`value`, or a usage error that names the nearest known words."""
    if value in accepted:
        return value
    listed = sorted(set(known))
    near = difflib.get_close_matches(value.replace("_", " "), sorted({*listed, *aliases}), n=3)
    hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(listed)}"
    raise typer.BadParameter(f"'{value}' is not known; {hint}", param_hint=flag)


def _json(request: str, result: SearchResult) -> dict[str, object]:
    return {
        "request": request,
        "read": [
            {"words": w.words, "field": w.field, "as": w.reading, "optional": w.optional} for w in result.criteria
        ],
        "unmatched": [w.words for w in result.unmatched],
        "total": result.total,
        "hits": [_row(hit) for hit in result.hits],
        "near": [_row(hit) for hit in result.near_misses],
    }


def _row(hit: Hit) -> dict[str, object]:
    asset = hit.asset
    return {
        "asset_id": asset.asset_id,
        "package": asset.asset_id,
        "score": hit.score,
        "outcome": asset.outcome,
        "category": asset.category.value,
        "category_confidence": asset.category.confidence,
        "extent_m": asset.extent_m,
        "mass_kg": asset.mass_kg,
        "why": [_match(a) for a in hit.matches],
        "lacks": [_match(a) for a in hit.misses],
    }


def _match(result: Match) -> dict[str, object]:
    return {
        "words": result.criterion.words,
        "field": result.field,
        "value": result.value,
        "confidence": round(result.confidence, 3),
        "evidence": result.evidence,
    }


def _show(result: SearchResult) -> None:
    for criterion in result.criteria:
        text.console.print(
            f"[dim]'{escape(criterion.words)}' read as {escape(criterion.reading)}[/dim]", soft_wrap=True
        )
    for criterion in result.unmatched:
        text.console.print(f"[yellow]'{escape(criterion.words)}' matched nothing[/yellow]", soft_wrap=True)
    shown = result.hits
    text.console.print(f"{result.total} found" + (f", {len(shown)} shown" if len(shown) < result.total else ""))
    for hit in shown:
        _show_hit(hit)
    if result.near_misses:
        text.console.print("nearest misses:")
        for hit in result.near_misses:
            _show_hit(hit)


def _show_hit(hit: Hit) -> None:
    asset = hit.asset
    size_cm = " × ".join(f"{100 * edge:.3g}" for edge in asset.extent_m)
    text.console.print(
        f"[bold]{escape(asset.asset_id)}[/bold]  {hit.score:.2f}  {escape(asset.category.value)}, {size_cm} cm, "
        f"{asset.mass_kg:.3g} kg, {asset.outcome}",
        soft_wrap=True,
        highlight=False,
    )
    for mark, results in (("+", hit.matches), ("-", hit.misses)):
        for a in results:
            sure = f"{a.confidence:.0%}; " if a.confidence else ""
            line = f"  {mark} '{a.criterion.words}': {a.field} {a.value} ({sure}{a.evidence})"
            text.console.print(escape(line), soft_wrap=True, highlight=False)
