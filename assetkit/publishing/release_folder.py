"""Writes a release folder: packages, the licences they are under, attributions, and a manifest of hashes.

    packages/<asset id>/   copies of the packages, byte for byte
    LICENCES/<SPDX id>.md  each licence with its address, its terms, its assets, and its text where it must go along
    ATTRIBUTION.md         author, source and licence of each asset, and that it was changed
    manifest.json          tool and version, assets, SHA-256 of every other file

Equal packages give equal bytes: no clock, no absolute path, sorted by name.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from assetkit.package.record import RECORD, read_record
from assetkit.publishing.licences import NOT_RECORDED, LicenceTerms, judge_licence
from jobs.cache import changed_files, file_sha256
from jobs.durable import exchange, sync_tree
from schemas.asset import AssetRecord
from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding
from schemas.outcome import ItemOutcome

MANIFEST, ATTRIBUTION, LICENCES, PACKAGES = "manifest.json", "ATTRIBUTION.md", "LICENCES", "packages"
MANIFEST_VERSION = 1
REVIEW = "review"  # what --allow has to name for assets that await a decision
_SHOWN = 5  # names of files in one finding


@dataclass(frozen=True)
class ReleasedAsset:
    """One asset of a release, with the licences it is under."""

    record: AssetRecord
    terms: tuple[LicenceTerms, ...]


@dataclass(frozen=True)
class WrittenRelease:
    """What became of a release: the assets in it, the refusals, and warnings. Nothing was written where `folder` is
    None.
    """

    folder: Path | None
    assets: tuple[str, ...]
    refused: tuple[Diagnostic, ...]
    warnings: tuple[Diagnostic, ...]


def publish_release(
    packages: Sequence[Path], out: Path, *, allowed: frozenset[str] = frozenset(), skip_refused: bool = False
) -> WrittenRelease:
    """Write the release of these packages to `out`, all of them or, with `skip_refused`, those that may be released.

    `allowed`: "nc", "nd", "review", and texts of licences that somebody has read. A release that lies in `out` is
    replaced in one step. Raises InvalidInput `asset/output-occupied` where something else lies there.
    """
    if out.exists() and any(out.iterdir()) and not (out / MANIFEST).is_file():
        headline = f"'{out.name}' holds something that is no release"
        raise InvalidInput(finding("asset/output-occupied", headline, where=Location(file=out.name)))
    released: list[ReleasedAsset] = []
    refused: list[Diagnostic] = []
    fresh = out.with_name(f".{out.name}.new")
    shutil.rmtree(fresh, ignore_errors=True)
    (fresh / PACKAGES).mkdir(parents=True)
    for package in sorted(packages, key=lambda each: each.name):
        asset, reasons = _judged(package, allowed)
        if asset is not None and not reasons:
            reasons = _copied(package, fresh / PACKAGES / package.name, asset.record)
        refused += reasons
        if asset is not None and not reasons:
            released.append(asset)
    names = tuple(asset.record.asset_id for asset in released)
    warnings = tuple(warning for asset in released for warning in _missing_author(asset))
    if not released or (refused and not skip_refused):
        shutil.rmtree(fresh)
        return WrittenRelease(None, names, tuple(refused), warnings)
    _write_texts(fresh, released)
    (fresh / MANIFEST).write_text(manifest_text(fresh, released))
    _into_place(fresh, out)
    return WrittenRelease(out, names, tuple(refused), warnings)


def _judged(package: Path, allowed: frozenset[str]) -> tuple[ReleasedAsset | None, tuple[Diagnostic, ...]]:
    """The asset of a package folder with its terms, or why it may not be released."""
    where = Location(file=package.name)
    record = read_record(package)
    if record is None:
        return None, (finding("asset/package-invalid", f"'{package.name}' is no package of Mana", where=where),)
    judged = judge_licence(record.source.license.value, allowed, where)
    reasons = list(judged.refused)
    if record.outcome is ItemOutcome.REVIEW and REVIEW not in allowed:
        reasons.append(finding("asset/release-unaccepted", f"'{package.name}' awaits a decision", where=where))
    return ReleasedAsset(record, judged.terms), tuple(reasons)


def _copied(package: Path, target: Path, record: AssetRecord) -> tuple[Diagnostic, ...]:
    """Copy the files of the record and the record itself; a finding when they are not those of the record.

    The copy is what is compared: a package that an ingest replaces meanwhile is seen as well.
    """
    damaged = [name for name in record.hashes if not (package / name).is_file()]
    for name in () if damaged else (*record.hashes, RECORD):
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(package / name, target / name)
    damaged = damaged or changed_files(target, record.hashes)
    if not damaged and read_record(target) != record:
        damaged = [RECORD]
    if not damaged:
        return ()
    headline = f"{len(damaged)} files are absent or not those of the record: {', '.join(damaged[:_SHOWN])}"
    return (finding("asset/library-package-damaged", headline, where=Location(file=package.name)),)


def _missing_author(asset: ReleasedAsset) -> tuple[Diagnostic, ...]:
    source = asset.record.source
    if source.author.value.lower() not in NOT_RECORDED or not any(terms.attribution for terms in asset.terms):
        return ()
    headline = f"{_ids(asset.terms)} asks to name the author of '{asset.record.asset_id}', and none is on record"
    return (finding("asset/attribution-incomplete", headline, where=Location(file=asset.record.asset_id)),)


def _write_texts(folder: Path, released: Sequence[ReleasedAsset]) -> None:
    (folder / ATTRIBUTION).write_text(_attribution(released))
    terms = {each.spdx: each for asset in released for each in asset.terms}
    (folder / LICENCES).mkdir()
    for spdx in sorted(terms):
        holders = [asset for asset in released if spdx in {each.spdx for each in asset.terms}]
        name = "".join(c if c.isascii() and (c.isalnum() or c in "-.") else "_" for c in spdx)
        (folder / LICENCES / f"{name}.md").write_text(_licence_page(terms[spdx], holders))


def _attribution(released: Iterable[ReleasedAsset]) -> str:
    lines = ["# Attribution", "", "Each package was made from the source named here; shape, scale, materials and"]
    lines += ["physics were changed, as its `record.json` lists.", ""]
    for asset in released:
        source = asset.record.source
        author = "author not on record" if source.author.value.lower() in NOT_RECORDED else source.author.value
        file = source.files[0].path if source.files else "a source without a file"
        lines.append(f"- **{asset.record.asset_id}**: {author}; source `{file}`; {_links(asset.terms)}")
    return "\n".join(lines) + "\n"


def _licence_page(terms: LicenceTerms, holders: Sequence[ReleasedAsset]) -> str:
    asks = ["attribution"] * terms.attribution + ["the same licence for changed versions"] * terms.share_alike
    forbids = ["commercial use"] * terms.non_commercial + ["changed versions"] * terms.no_derivatives
    lines = [f"# {terms.name}", "", f"SPDX id or text on record: {terms.spdx}", *([terms.url] if terms.url else []), ""]
    lines += [f"It asks for: {', '.join(asks) or 'nothing'}. It forbids: {', '.join(forbids) or 'nothing'}.", ""]
    lines += [f"- {asset.record.asset_id}: {asset.record.source.author.value}" for asset in holders]
    if terms.needs_text:
        lines += ["", "## Text", "", (files("assetkit.publishing.texts") / f"{terms.spdx}.md").read_text().rstrip()]
    return "\n".join(lines) + "\n"


def manifest_text(folder: Path, released: Sequence[ReleasedAsset]) -> str:
    """The manifest of the release in `folder` as JSON."""
    assets = [
        {
            "asset_id": asset.record.asset_id,
            "outcome": asset.record.outcome.value,
            "licences": [each.spdx for each in asset.terms],
            "author": asset.record.source.author.value,
            "sources": [{"path": each.path, "sha256": each.sha256} for each in asset.record.source.files],
        }
        for asset in released
    ]
    hashes = {p.relative_to(folder).as_posix(): file_sha256(p) for p in sorted(folder.rglob("*")) if p.is_file()}
    tool = {"name": "mana-sim", "version": version("mana-sim")}
    manifest = {"manifest_version": MANIFEST_VERSION, "tool": tool, "assets": assets, "files": hashes}
    return json.dumps(manifest, indent=1) + "\n"


def _into_place(fresh: Path, out: Path) -> None:
    """Move a whole release to its place; a reader sees the old one or all of the new one."""
    sync_tree(fresh)
    if out.exists() and exchange(fresh, out):
        shutil.rmtree(fresh, ignore_errors=True)
        return
    shutil.rmtree(out, ignore_errors=True)
    fresh.rename(out)


def _ids(terms: Iterable[LicenceTerms]) -> str:
    return " and ".join(each.spdx for each in terms)


def _links(terms: Iterable[LicenceTerms]) -> str:
    return " and ".join(f"[{each.spdx}]({each.url})" if each.url else each.spdx for each in terms)
