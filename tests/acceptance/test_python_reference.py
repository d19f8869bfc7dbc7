"""The blocks of docs/reference/python.md run in order, in one folder, and the page names every name of every face."""

from __future__ import annotations

import importlib
import re
import runpy
from pathlib import Path

import pybullet_data
import pytest

from tests.support.source_tree import PACKAGES, ROOT

PAGE = ROOT / "docs" / "reference" / "python.md"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
ENTRY_POINTS = ("assetkit.ingest", "scenec.compile_program", "runtime_plan.load", "runtime_plan.sample")
PROMISED = (*ENTRY_POINTS, "replay.augment", "simgap.find")


def test_the_blocks_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    arm = Path(pybullet_data.getDataPath()) / "franka_panda"
    runpy.run_path(str(ROOT / "examples" / "04_augment.py"))["record"](Path("episode"), arm)
    runpy.run_path(str(ROOT / "examples" / "05_find_gap.py"))["record"](Path("door"))
    blocks = BLOCK.findall(PAGE.read_text())
    assert len(blocks) == 6
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)


def test_each_promised_entry_point_is_called() -> None:
    text = "".join(BLOCK.findall(PAGE.read_text()))
    assert [call for call in PROMISED if f"{call}(" not in text] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_the_page_names_all_that_a_face_offers(package: str) -> None:
    words = set(re.findall(r"\w+", PAGE.read_text()))
    assert set(importlib.import_module(package).__all__) - words == set()
