"""Paired materials stay within what acceptance exercised, or the author is told, with the range and who failed."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenec import compile_program
from schemas.diagnostics import Diagnostic
from tests.support.bad_inputs.scene import pool
from tests.support.scene.library import cube, tried

HALF_KG, OWN_KGM3 = 0.5, 500.0


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    tried(folder)
    cube(folder)
    return folder


def told(library: Path, values: str, asset: str = "tried", of: str = "a") -> list[Diagnostic]:
    program = library.parent / "program.yaml"
    program.write_text(pool(asset, of=of) + f"variants: {{materials: [{{id: coat, objects: [a], {values}}}]}}\n")
    diagnostics = compile_program(program, library).report.diagnostics
    return [d for d in diagnostics if d.code == "scene/beyond-exercised"]


@pytest.mark.parametrize(
    ("values", "quantity", "value", "bound"),
    [
        ("dynamic_friction: 0.35", "friction", 0.35, "0.4 to 0.9"),
        ("dynamic_friction: 1.0, static_friction: 1.0", "friction", 1.0, "0.4 to 0.9"),
        ("static_friction: 0.3", "friction", 0.3, "0.4 to 0.9"),  # dynamic friction never exceeds static
        (f"density_kgm3: {2.1 * OWN_KGM3}", "mass", 2.1 * HALF_KG, "0.25 to 1"),
        (f"density_kgm3: {0.4 * OWN_KGM3}", "mass", 0.4 * HALF_KG, "0.25 to 1"),
    ],
)
def test_a_value_beyond_the_range_is_told(library: Path, values: str, quantity: str, value: float, bound: str):
    [diagnostic] = told(library, values)
    assert f"`coat` gives `tried` a {quantity}" in diagnostic.headline
    assert (diagnostic.value, diagnostic.bound) == (pytest.approx(value), bound)
    assert diagnostic.where.line is not None


@pytest.mark.parametrize(
    "values",
    [
        "dynamic_friction: 0.4",
        "dynamic_friction: 0.9, static_friction: 1.1",
        f"density_kgm3: {2 * OWN_KGM3}",
        "roughness: 0.2",
    ],
)
def test_values_within_and_looks_alone_are_not(library: Path, values: str):
    assert told(library, values) == []


def test_an_asset_that_nobody_exercised_and_other_objects_are_left_alone(library: Path):
    assert told(library, "dynamic_friction: 0.01", asset="cube") == []
    assert told(library, "dynamic_friction: 0.01", of="b") == []
