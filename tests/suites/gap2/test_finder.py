"""The finder's entrance: effects left out are no candidates, and the library is whole again afterwards."""

from __future__ import annotations

import ast
from pathlib import Path

from simgap.case import case_of
from simgap.recording.read import read
from tests.suites.gap2 import finder
from tests.suites.gap2.generate.cases import mechanism_case, write_case


def test_left_out_effect_is_no_candidate(tmp_path: Path) -> None:
    outcome = read(write_case(mechanism_case(0), tmp_path))
    assert outcome.value is not None
    names = [c.effect.name for c in case_of(outcome.value, finder.ENGINE).problem.candidates()]
    assert "joint.coulomb_friction" in names
    with finder._library_without(("joint.coulomb_friction",)):
        fewer = [c.effect.name for c in case_of(outcome.value, finder.ENGINE).problem.candidates()]
    assert fewer == [n for n in names if n != "joint.coulomb_friction"]
    again = [c.effect.name for c in case_of(outcome.value, finder.ENGINE).problem.candidates()]
    assert again == names


def test_unreadable_folder_is_refused_not_raised(tmp_path: Path) -> None:
    assert list(finder.find_in(tmp_path, tmp_path / "out")) == ["refused"]


def test_generator_and_finder_do_not_import_one_another() -> None:
    """As the import contracts hold it; here by the text of the files, without the graph."""
    here = Path(finder.__file__).parent
    for path in (here / "generate").glob("*.py"):
        assert not {"sim", "simgap", "schemas"} & {name.partition(".")[0] for name in _imports(path)}, path.name
    assert not [name for name in _imports(here / "finder.py") if name.startswith("tests")]


def _imports(path: Path) -> list[str]:
    nodes = list(ast.walk(ast.parse(path.read_text())))
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    return names + [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
