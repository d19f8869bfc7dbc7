"""Files that are refused before they are read."""

from __future__ import annotations

from pathlib import Path

import pytest

from assetkit.readers.by_format import READERS
from assetkit.sources.discover import discover
from assetkit.sources.screening import file_findings, require_surface
from geom.mesh.primitives import cube
from schemas.diagnostics import InvalidInput
from schemas.evidence import declared
from schemas.model import Mesh, Model


@pytest.mark.parametrize(
    ("name", "code", "tool"), [("arm.urdf.xacro", "robot/xacro", "xacro"), ("model.sdf", "robot/sdf", "gz sdf")]
)
def test_templates_and_models_of_other_tools_say_what_to_run(name: str, code: str, tool: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("<robot/>")
    (asset,) = discover([tmp_path / name])
    (refused,) = file_findings(asset, READERS)
    assert refused.code == code
    assert tool in refused.help


@pytest.mark.parametrize("coordinate", [1e101, -1e308, 1.7e308])
def test_a_coordinate_whose_volume_is_no_number_is_refused(coordinate: float) -> None:
    points, triangles, _ = cube(1.0)
    points[0, 1] = coordinate
    with pytest.raises(InvalidInput) as refused:
        require_surface(
            Model((Mesh("cube", points, triangles),), (), (), (), declared(1.0, "test"), declared("z", "test"))
        )
    assert refused.value.diagnostic.code == "asset/nonfinite-vertices"
    assert refused.value.diagnostic.value == abs(coordinate)
