"""Files that are refused before they are read."""

from __future__ import annotations

from pathlib import Path

import pytest

from assetkit.readers.by_format import READERS
from assetkit.sources.discover import discover
from assetkit.sources.screening import file_findings


@pytest.mark.parametrize(
    ("name", "code", "tool"), [("arm.urdf.xacro", "robot/xacro", "xacro"), ("model.sdf", "robot/sdf", "gz sdf")]
)
def test_templates_and_models_of_other_tools_say_what_to_run(name: str, code: str, tool: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("<robot/>")
    (asset,) = discover([tmp_path / name])
    (refused,) = file_findings(asset, READERS)
    assert refused.code == code
    assert tool in refused.help
