"""Recovery as a stage: off by default, marked when on, seen in pictures and section, no evidence for physics."""

from __future__ import annotations

from pathlib import Path

from assetkit.options import Options
from assetkit.pipeline import STAGES, run_stages
from assetkit.sources.discover import discover
from assetkit.stage import Appearance, Draft, Physics, Previews, Tools
from assetkit.stage_log import StageLog
from assetkit.stages.intake import ReadSource
from jobs.cache import Cache
from schemas.appearance.record import DegradedReason
from sim.fake import FakeSimulator
from tests.assetkit.stages.test_semantics import TUBE
from tests.support.bad_inputs.assets import obj_text

LOST = "newmtl Material\nKd 1 1 1\nmap_Kd absent.png\n"


def taken(folder: Path, *, recover: bool, mtl: str = LOST) -> tuple[Draft, StageLog]:
    """A mug whose picture is absent, after all stages up to its pictures."""
    folder.mkdir()
    (folder / "look.mtl").write_text(mtl)
    (folder / "mug.obj").write_text(f"# units: m, z up\nmtllib look.mtl\nusemtl Material\n{obj_text(TUBE, '')}")
    options = Options(units="m", up_axis="z", recover_appearance=recover)
    item = ReadSource().run(discover([folder / "mug.obj"])[0], options).objects[0]
    log = StageLog({})
    tools = Tools(FakeSimulator(), folder / "work", options)
    draft = run_stages(
        Draft("mug", "mug.obj", item), tools, log, Cache(folder / "cache"), "key", STAGES.up_to("previews")
    )
    assert draft is not None
    return draft, log


def codes(log: StageLog) -> list[str]:
    return [note.code for note in log.diagnostics]


def test_without_the_option_the_surface_is_marked_and_left(tmp_path: Path) -> None:
    draft, log = taken(tmp_path / "plain", recover=False)
    (mark,) = draft[Appearance].section.degraded
    assert (mark.material, mark.reason) == ("Material", DegradedReason.LOST_TEXTURE)
    assert draft.recovery is None
    assert draft.model.materials[0].base_color == (1.0, 1.0, 1.0)
    assert "asset/appearance-recovered" not in codes(log)


def test_with_the_option_the_mug_is_ceramic_in_pictures_and_section_and_weighs_the_same(tmp_path: Path) -> None:
    plain, _ = taken(tmp_path / "plain", recover=False)
    draft, log = taken(tmp_path / "recovered", recover=True)
    assert draft.recovery is not None
    (surface,) = draft.recovery.section.recovered
    assert (surface.family.value, surface.material) == ("ceramic", "Material")
    assert surface.family.confidence <= 0.5
    assert len(surface.candidates) == 4
    assert any("shape in the pictures" in candidate.terms for candidate in surface.candidates)
    assert codes(log).count("asset/appearance-recovered") == 1
    (note,) = (note for note in log.diagnostics if note.code == "asset/appearance-recovered")
    assert f"{surface.family.confidence:.2f}" in note.headline
    values = draft.recovery.section.render_materials[0].values
    assert values["base_color"].source == "inferred"
    assert values["base_color"].confidence == surface.family.confidence
    assert draft.recovery.section.colours == plain[Appearance].section.colours
    assert draft[Physics].mass.mass_kg == plain[Physics].mass.mass_kg
    assert draft[Physics].section == plain[Physics].section
    assert draft[Previews].images["thumbnail"] != plain[Previews].images["thumbnail"]


def test_what_the_source_states_is_left_alone(tmp_path: Path) -> None:
    plain, _ = taken(tmp_path / "plain", recover=False, mtl="newmtl Material\nKd 0.6 0.1 0.1\n")
    draft, log = taken(tmp_path / "recovered", recover=True, mtl="newmtl Material\nKd 0.6 0.1 0.1\n")
    assert draft.recovery is not None
    assert draft.recovery.section == plain[Appearance].section
    assert draft.model.materials == plain.model.materials
    assert "asset/appearance-recovered" not in codes(log)
