"""Acceptance in the demo: what the suites found on a rigid package and on the mechanism, and a GIF of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from assetkit.batch.suite_rows import VIDEOS, SuiteRow, suite_rows
from assetkit.library.accept import accept_files
from assetkit.library.acceptance_request import AcceptanceRequest
from assetkit.library.validate import main_usd_files
from assetkit.package.record import RECORD
from cli.engines import SIMULATOR
from schemas.asset import AssetRecord

_HANDLED = "manipulated"  # the suite whose motion is worth a film


@dataclass(frozen=True)
class AcceptanceDemo:
    """The suites on the record of a package, and the GIF of its motions; "" where the gripper moved nothing."""

    name: str
    suites: tuple[SuiteRow, ...]
    video: str


def acceptance_demo(library: Path, generated: Path, out: Path) -> tuple[AcceptanceDemo, ...]:
    """A rigid package of `library` that a gripper carries, and those of `generated`, filmed in `VIDEOS` of `out`.

    The rows are those of the records; the suites run again, at the values of the package only, to be filmed.
    """
    packages = [file.parent for folder in (library, generated) for file in sorted(folder.glob(f"*/{RECORD}"))]
    records = {package: AssetRecord.model_validate_json((package / RECORD).read_bytes()) for package in packages}
    rigid = [package for package in packages if package.parent == library]
    chosen = _most_exercised(rigid, records), *(p for p in packages if p.parent == generated)
    demos: list[AcceptanceDemo] = []
    for package in filter(None, chosen):
        video = out / VIDEOS / f"{package.name}.gif"
        video.unlink(missing_ok=True)
        request = AcceptanceRequest(
            main_file=str(main_usd_files(package)[0].absolute()),
            engine=SIMULATOR,
            thorough=False,
            video=str(video.absolute()),
        )
        for _ in accept_files([request]):  # What it finds is on record; a film that does not come leaves the table.
            pass
        place = video.relative_to(out).as_posix() if video.is_file() else ""
        demos.append(AcceptanceDemo(package.name, suite_rows(records[package].acceptance.suites), place))
    return tuple(demos)


def _most_exercised(packages: Sequence[Path], records: dict[Path, AssetRecord]) -> Path | None:
    """The package with most suites of those that a gripper carries; None without any."""
    carried = {
        package: sum(suite.outcome == "passed" for suite in records[package].acceptance.suites)
        for package in packages
        if any(s.name == _HANDLED and s.outcome == "passed" for s in records[package].acceptance.suites)
    }
    return max(carried, key=lambda package: carried[package], default=None)
