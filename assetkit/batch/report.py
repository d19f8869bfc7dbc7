"""Builds and writes the report of a batch from its items: `report.json` for tools, an HTML contact sheet for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from assetkit.batch.joint_rows import joint_rows
from assetkit.batch.suite_rows import VIDEOS, suite_rows, withdrawn_roles
from assetkit.package.record import RECORD
from jobs.cache import write_atomically
from schemas.asset import AssetRecord
from schemas.outcome import EndpointUse, ItemOutcome
from schemas.report import IngestReport, ReportItem


def build_report(items: Iterable[ReportItem], *, wall_seconds: float, interrupted: bool) -> IngestReport:
    """The report over all items; `totals` counts outcomes, packages, cached items and seconds per stage."""
    items = tuple(items)
    outcomes = Counter(i.outcome for i in items)
    seconds: Counter[str] = Counter()
    for item in items:
        seconds.update(item.seconds)
    totals: dict[str, float] = {
        "items": len(items),
        **{o.value: outcomes[o] for o in ItemOutcome},
        "packages": sum(len(i.packages) for i in items),
        "cached": sum(bool(i.cached == ("item",)) for i in items),
        **_endpoint_totals(items),
        "wall_seconds": round(wall_seconds, 2),
        **{f"{stage}_seconds": round(spent, 2) for stage, spent in sorted(seconds.items())},
    }
    return IngestReport(items=items, totals=totals, interrupted=interrupted)


def _endpoint_totals(items: Sequence[ReportItem]) -> dict[str, float]:
    """Requests, tokens and cost of the multimodal endpoint in this run; empty when it was not used."""
    uses = [i.endpoint for i in items if i.endpoint is not None and i.cached != ("item",)]
    spent = sum(uses, EndpointUse()).model_dump(exclude_none=True)
    return {f"endpoint_{name}": round(value, 6) for name, value in spent.items()} if uses else {}


def write_report(report: IngestReport, out: Path) -> None:
    """Write `report.json` and `report.html` into `out`."""
    write_atomically(out / "report.json", report.model_dump_json(indent=1).encode())
    _write_html(report, out)


def _write_html(report: IngestReport, out: Path) -> None:
    """Streams the page to disk, so that the records of ten thousand packages are never all in memory."""
    loader = PackageLoader("assetkit.batch", "templates")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("report.html")
    packages = ((item, [name for name in item.packages if (out / name / RECORD).is_file()]) for item in report.items)
    rows = ((item, [_card(out, name) for name in names]) for item, names in packages)
    temporary = out / ".report.html"
    text = page.stream(report=report, rows=rows, outcomes=[o.value for o in ItemOutcome])
    text.enable_buffering(1000)
    text.dump(str(temporary), encoding="utf-8")
    temporary.replace(out / "report.html")


def _card(out: Path, name: str) -> dict[str, object]:
    """The template variables of one package on the contact sheet."""
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
