"""Writes the report of a batch from its items: `report.json` for tools, and a page for people.

The page opens from disk without a network and holds tens of thousands of items: `report.html` has one short row per
item, drawn as they are scrolled into view; what is known about an item is in files of `DETAILS`, which the page loads
when the item is chosen.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from assetkit.batch.finished_items import FinishedItems
from assetkit.batch.joint_rows import joint_rows
from assetkit.batch.report_file import FinishedBatch, write_report_json
from assetkit.batch.suite_rows import VIDEOS, suite_rows, withdrawn_roles
from assetkit.package.record import RECORD
from schemas.asset import AssetRecord
from schemas.outcome import ItemOutcome
from schemas.report import ReportItem

DETAILS = ".report"  # No package can have this name.
PAGE = "report.html"
ITEMS_PER_FILE = 100  # of details: a file of some hundred kilobytes


def write_report(batch: FinishedBatch, items: FinishedItems) -> None:
    """Write `report.json`, `report.html` and its details into the folder of the batch, item by item."""
    write_report_json(batch, items.lines())
    environment = Environment(
        loader=PackageLoader("assetkit.batch", "templates"), autoescape=True, undefined=StrictUndefined
    )
    fresh, place = batch.out / f"{DETAILS}.new", batch.out / DETAILS
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir(parents=True)
    temporary = batch.out / f".{PAGE}"
    shell = environment.get_template(PAGE).render(
        batch=batch, outcomes=[o.value for o in ItemOutcome], per_file=ITEMS_PER_FILE, details=DETAILS
    )
    before, after = shell.split("@rows@")
    with temporary.open("w", encoding="utf-8", errors="backslashreplace") as page:
        page.write(before)
        for number, group in enumerate(_groups(items, ITEMS_PER_FILE)):
            cards = [(item, _cards(batch.out, item)) for item in group]
            page.write("".join(f"{_script(_row(item, shown))},\n" for item, shown in cards))
            texts = [environment.get_template("details.html").render(item=item, cards=shown) for item, shown in cards]
            file = fresh / f"{number:05d}.js"
            file.write_text(f"details({number}, {_script(texts)});\n", encoding="utf-8", errors="backslashreplace")
        page.write(after)
    shutil.rmtree(place, ignore_errors=True)
    fresh.replace(place)
    temporary.replace(batch.out / PAGE)


def _groups(items: Iterable[ReportItem], size: int) -> Iterator[list[ReportItem]]:
    """The items in lists of `size`, the last one perhaps shorter."""
    group: list[ReportItem] = []
    for item in items:
        group.append(item)
        if len(group) == size:
            yield group
            group = []
    if group:
        yield group


def _row(item: ReportItem, cards: list[dict[str, Any]]) -> list[object]:
    """What the list shows of an item: source, outcome, codes; name, category, size and mass of its first package."""
    first = cards[0] if cards else None
    record: AssetRecord | None = None if first is None else first["record"]
    return [
        item.source,
        item.outcome.value,
        list(item.codes),
        "" if first is None else first["name"],
        "" if record is None else record.semantics.category.value,
        "" if first is None else " × ".join(str(e) for e in first["extent_cm"]) + " cm",
        "" if record is None else f"{record.physics.mass_kg.value:.3g} kg",
    ]


def _script(value: object) -> str:
    """JSON that is safe within a script element: no text can close it or open a comment."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _cards(out: Path, item: ReportItem) -> list[dict[str, Any]]:
    return [_card(out, name) for name in item.packages if (out / name / RECORD).is_file()]


def _card(out: Path, name: str) -> dict[str, Any]:
    """The template variables of one package."""
    record = AssetRecord.model_validate_json((out / name / RECORD).read_bytes())
    method = record.physics.collision_method
    chosen = next((c for c in record.physics.candidates if c.method == method), None)
    video = f"{VIDEOS}/{name}.gif"
    return {
        "name": name,
        "record": record,
        "extent_cm": [round(100 * e, 1) for e in record.geometry.extent_m.value],
        "collider": method if chosen is None or chosen.accepted else f"{method}, a stand-in ({chosen.reason})",
        "shapes": chosen.shapes if chosen else 0,
        "poses": len(record.acceptance.stable_poses),
        "joints": joint_rows(
            [joint.value for joint in record.physics.joints],
            record.joint_uses,
            [anchor.value for anchor in record.anchors],
        ),
        "suites": suite_rows(record.acceptance.suites),
        "withdrawn": withdrawn_roles(record.diagnostics),
        "video": video if (out / video).is_file() else "",
    }
