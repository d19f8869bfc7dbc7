"""The search for many folders: each costs only itself, and has a place of its own."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from jobs.placement import Placement
from simgap import find_many as many
from simgap.find_many import find_many, folder_names

WORKER = """
import os, sys
from pathlib import Path
from jobs.json_cell import answer
from schemas.diagnostics import InvalidInput, finding
def search(request):
    name = Path(request['measurement']).name
    if name == 'crash': os.abort()
    if name == 'bad': raise InvalidInput(finding('gap/missing-file', 'no table'))
    return {'verdict': {'status': 'no_effect', 'statement': f"{request['engine']} {Path(request['out']).name}"}}
answer(search, *sys.argv[1:3])
"""


@pytest.mark.parametrize("jobs", [1, 3])
def test_a_folder_that_crashes_or_is_refused_costs_only_itself(
    jobs: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "a_search.py").write_text(WORKER)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    monkeypatch.setattr(many, "WORKER", "a_search")
    folders = [tmp_path / name for name in ("door", "crash", "bad", "other/door")]
    found = find_many(folders, tmp_path / "out", engine="an:engine", placement=Placement(jobs))
    answers = {one.measurement: one for one in found}
    assert answers.keys() == set(folders)
    said = {folder: one.verdict.statement for folder, one in answers.items() if one.verdict is not None}
    assert said == {folders[0]: "an:engine door", folders[3]: "an:engine door_2"}
    refused = {folder.name: one.refused.code for folder, one in answers.items() if one.refused is not None}
    assert refused == {"crash": "gap/stopped", "bad": "gap/missing-file"}


def test_namesakes_have_numbers_that_no_folder_has():
    named = [Path("/a/door"), Path("/b/door_2"), Path("/c/door"), Path("/d/door")]
    assert folder_names(named) == ["door", "door_2", "door_3", "door_4"]
