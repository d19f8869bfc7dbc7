"""`mana assets show` prints what the suites on a record found."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from typer.testing import CliRunner

from assetkit.package.record import RECORD
from cli.main import app
from schemas.acceptance import Check, Margin, SuiteSection
from schemas.appearance.record import AppearanceSection, MaterialRecord
from schemas.diagnostics import finding
from schemas.evidence import declared, default, measured


def shown(
    folder: Path,
    acceptance: dict[str, object],
    diagnostics: Sequence[object],
    appearance: dict[str, object] | None = None,
) -> str:
    record = {"asset_id": "mug", "outcome": "accepted", "acceptance": acceptance, "diagnostics": diagnostics}
    record |= {section: {} for section in ("geometry", "semantics", "physics", "source")}
    record |= {"appearance": appearance} if appearance else {}
    (folder / RECORD).write_text(json.dumps(record))
    result = CliRunner().invoke(app, ["assets", "show", str(folder)], catch_exceptions=False)
    assert result.exit_code == 0
    return result.output


def test_margins_failed_figures_and_withdrawn_roles_are_printed(tmp_path: Path) -> None:
    good = Check(name="held", value=1.0, bound=1.0, unit="", passed=True)
    bad = Check(name="leans", value=7.5, bound=5.0, unit="deg", passed=False)
    margin = Margin(quantity="friction", low=0.45, high=0.8, bounds=(0.3, 0.8))
    suites = (
        SuiteSection(name="manipulated", outcome="passed", checks=(good,), margins=(margin,)),
        SuiteSection(name="receptacle", outcome="failed", checks=(good, bad)),
    )
    cause = finding("asset/receptacle-spill", "it leans", value=7.5, bound=5.0, unit="deg")
    taken = finding("asset/role-withdrawn", "the role 'receptacle' is not borne out", because=(cause,))
    findings = [each.model_dump(mode="json") for each in (cause, taken)]
    said = shown(tmp_path, {"suites": [suite.model_dump(mode="json") for suite in suites]}, findings)
    assert "1 of 1 checks; holds for friction >= 0.45" in said
    assert "1 of 2 checks; leans: 7.5 deg, bound 5 deg" in said
    assert said.count("is not borne out (it leans: 7.5 deg, bound 5 deg)") == 1


def test_materials_and_texel_density_are_printed(tmp_path: Path) -> None:
    values = {"roughness": declared(0.2, "the file"), "ior": default(1.5)}
    shaders = ("UsdPreviewSurface", "OpenPBR", "OmniGlass")
    material = MaterialRecord(name="pane", optics="transmissive", values=values, shaders=shaders)
    density = measured(812.5, "median")
    section = AppearanceSection(materials=("pane",), textures=(), render_materials=(material,), texels_per_m=density)
    text = " ".join(shown(tmp_path, {}, [], section.model_dump(mode="json")).split())
    for words in ("texels_per_m", "812.5", "material pane", "transmissive:", "OmniGlass", "1 of 2 values"):
        assert words in text


def test_a_record_of_an_earlier_version_has_no_suites(tmp_path: Path) -> None:
    assert "suites" not in shown(tmp_path, {"checks": []}, [])


def test_ranges_over_which_all_suites_passed_are_printed(tmp_path: Path) -> None:
    """Of a whole record; friction and mass on record are 0.4 and 0.5 kg."""
    record = json.loads((Path(__file__).parents[2] / "data" / "record.json").read_text()) | {"asset_id": "mug"}
    friction = record["physics"]["contacts"][0]["value"]["dynamic_friction"]
    margins = (
        Margin(quantity="friction", low=0.5 * friction, high=2.0 * friction, bounds=(0.1 * friction, 2.0 * friction)),
        Margin(quantity="mass_kg", low=0.25, high=1.0, bounds=(0.25, 1.0)),
    )
    suite = SuiteSection(name="manipulated", outcome="passed", margins=margins)
    record["acceptance"]["suites"] = [suite.model_dump(mode="json")]
    (tmp_path / "mug").mkdir()
    (tmp_path / "mug" / RECORD).write_text(json.dumps(record))
    result = CliRunner().invoke(app, ["assets", "show", str(tmp_path / "mug")], catch_exceptions=False)
    limits = f"friction {0.5 * friction:.3g} to {2.0 * friction:.3g} (beyond, manipulated failed)"
    assert f"may be varied within {limits} and mass 0.25 to 1 kg" in " ".join(result.output.split())
