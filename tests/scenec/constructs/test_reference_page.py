"""The programs of the page of constructs compile, and what their plans draw is valid."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from scenec.compile import compile_program
from schemas.diagnostics import Severity
from tests.support.scene import library as scene_library
from tests.support.scene.drawn import refused

PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "scene-constructs.md").read_text()
PROGRAMS = {
    re.findall(r"^## `?([\w.]+)", PAGE[: block.start()], re.MULTILINE)[-1] + f"_{k}": block[1]
    for k, block in enumerate(re.finditer(r"```yaml\n(.*?)```", PAGE, re.DOTALL))
}


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scene_library.library(tmp_path_factory.mktemp("library"), cubes=2)


@pytest.mark.parametrize("name", PROGRAMS)
def test_each_program_of_the_page_compiles_and_its_draws_are_valid(name: str, packages: Path, tmp_path: Path):
    (tmp_path / "program.yaml").write_text(PROGRAMS[name])
    compiled = compile_program(tmp_path / "program.yaml", packages, diversity=0.05)
    assert [d.code for d in compiled.report.diagnostics if d.severity is Severity.ERROR] == []
    assert compiled.report.verdict == "compiled"
    assert compiled.plan is not None
    assert refused(compiled.plan, 100) == []


def test_every_section_of_the_page_has_a_program():
    sections = set(re.findall(r"^## `?([\w.]+)", PAGE, re.MULTILINE))
    assert {name.rsplit("_", 1)[0] for name in PROGRAMS} == sections
