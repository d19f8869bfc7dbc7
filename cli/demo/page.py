"""The page of pictures that `mana demo` leaves behind."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from assetkit.batch.report_file import FinishedBatch
from assetkit.package.package import PREVIEWS
from assetkit.package.record import RECORD
from cli.demo.acceptance import AcceptanceDemo
from cli.demo.gap import GapDemo
from cli.demo.gate import Spoiled
from cli.demo.mechanism import MechanismDemo
from cli.demo.replay import ReplayDemo
from cli.demo.scene import SceneDemo
from cli.demo.search import SearchDemo
from cli.demo.sheets import SheetsDemo
from cli.demo.task import TaskDemo
from jobs.cache import write_atomically
from schemas.asset import AssetRecord
from schemas.diagnostics import Diagnostic, Severity
from schemas.exercised import exercised_ranges
from simgap.report.html import PICTURES

_CAPTIONS = {
    "overlay.png": "One push that the search never learned from.",
    "unexplained.png": "Torque that the model does not account for, with the law that was found on top.",
    "ladder.png": "The error that is left, step by step.",
}


def write_page(
    report: FinishedBatch,
    verdicts: dict[Path, tuple[Diagnostic, ...]],
    spoiled: tuple[Spoiled, ...],
    sheets: SheetsDemo | None,
    searches: tuple[SearchDemo, ...],
    scene: SceneDemo | None,
    mechanism: MechanismDemo | None,
    accepted: tuple[AcceptanceDemo, ...],
    replay: ReplayDemo | None,
    tasks: TaskDemo | None,
    gap: GapDemo,
    out: Path,
) -> Path:
    """Write `index.html` in `out`: what went in, what came out, who says it is right. Returns its path."""
    library = out / "library"
    cards = [_card(library, name, verdicts) for item in report.items for name in item.packages]
    refused = [item for item in report.items if not item.packages]
    loader = PackageLoader("cli.demo", "templates")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("demo.html")
    path = out / "index.html"
    html = page.render(
        report=report,
        cards=cards,
        mechanisms=[card for card in cards if (library / str(card["name"]) / PREVIEWS / "joints.png").is_file()],
        grasped=_grasped(cards),
        refused=refused,
        spoiled=spoiled,
        sheets=sheets,
        searches=searches,
        scene=scene,
        mechanism=mechanism,
        accepted=accepted,
        replay=replay,
        tasks=tasks,
        gap=gap,
        pictures=_pictures(out, gap),
    )
    write_atomically(path, html.encode())
    return path


def _grasped(cards: list[dict[str, object]]) -> dict[str, object] | None:
    """The object that offers most kinds of affordance, of those with a grasp; None without any."""
    offers = []
    for card in cards:
        record = card["record"]
        assert isinstance(record, AssetRecord), "cards hold records"
        standing = [e.value.kind for e in record.affordances if e.confidence > 0.0]
        regions = sorted({kind.replace("_", " ") for kind in standing} - {"grasp"})
        if "grasp" in standing:
            offers.append({"name": card["name"], "regions": regions})
    return max(offers, key=lambda offer: len(offer["regions"]), default=None)


def _pictures(out: Path, gap: GapDemo) -> list[tuple[str, str]]:
    """Caption and place of each picture of the sim gap that was drawn."""
    places = ((caption, f"{gap.folder}/{PICTURES}/{name}") for name, caption in _CAPTIONS.items())
    return [(caption, place) for caption, place in places if (out / place).is_file()]


def _card(library: Path, name: str, verdicts: dict[Path, tuple[Diagnostic, ...]]) -> dict[str, object]:
    findings = [d for file, found in verdicts.items() if file.is_relative_to(library / name) for d in found]
    record = AssetRecord.model_validate_json((library / name / RECORD).read_bytes())
    return {
        "name": name,
        "record": record,
        "extent_cm": [round(100 * e, 1) for e in record.geometry.extent_m.value],
        "chosen": next((c for c in record.physics.candidates if c.method == record.physics.collision_method), None),
        "places": [a.value for a in record.anchors],
        "exercised": exercised_ranges(record),
        "shaders": sorted({shader for each in record.appearance.render_materials for shader in each.shaders}),
        "valid": not any(d.severity is Severity.ERROR for d in findings),
    }
