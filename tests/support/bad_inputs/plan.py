"""The smallest plan for every `plan/` code that loading one can meet: one sound plan with one thing changed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from tests.support.plan.library import grid_plan, round_body

SOUND = grid_plan(1, 1, bodies=(round_body("coin", 0.02, 8),))


def changed(change: Callable[[dict], None]) -> str:
    """The sound plan after `change`."""
    document = SOUND.model_dump(mode="json")
    change(document)
    return json.dumps(document)


def _packaged(document: dict) -> None:
    document["bodies"][0] |= {"package": "coin", "package_hash": "0" * 64}


def _unknown_place(document: dict) -> None:
    document["combinations"][0]["things"][0]["place"] = 1


SAMPLES: dict[str, str | None] = {
    "plan/missing-file": None,
    "plan/unreadable": '{"schema_version": "1.0", "scene',
    "plan/unknown-version": changed(lambda d: d.update(schema_version="2.0")),
    "plan/invalid-value": changed(lambda d: d.pop("clearance_m")),
    "plan/inconsistent": changed(_unknown_place),
    "plan/missing-package": changed(_packaged),
    "plan/changed-package": changed(_packaged),
}
NOT_FROM_A_PLAN: dict[str, str] = {
    "plan/no-view": "tests/runtime_plan/test_cameras.py",
    "plan/unreadable-samples": "tests/runtime_plan/test_samples_file.py",
    "plan/other-plan": "tests/runtime_plan/test_samples_file.py",
    "plan/unknown-choice": "tests/runtime_plan/test_restriction.py",
    "plan/nothing-left": "tests/runtime_plan/test_restriction.py",
}


def write(code: str, folder: Path) -> tuple[Path, Path]:
    """The plan file of a sample and the folder of its packages, written into `folder`."""
    path, packages = folder / "plan.json", folder / "packages"
    packages.mkdir()
    text = SAMPLES[code]
    if text is not None:
        path.write_text(text)
    if code == "plan/changed-package":
        (packages / "coin").mkdir()
        (packages / "coin" / "record.json").write_text("{}")
    return path, packages
