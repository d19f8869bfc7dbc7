"""Programs with something broken in them never end in an exception: a problem, or findings with a place."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from scenec.bind.asset_library import AssetLibrary
from scenec.bind.components import lower
from scenec.source.read import read_program

TEXTS = [path.read_text() for path in sorted((Path(__file__).parents[1] / "data" / "scenes").glob("*.yaml"))]
PROGRAMS = [YAML(typ="safe", pure=True).load(text) for text in TEXTS if "include" not in text]
ODD: list[Any] = [
    *(None, True, 0, -1, 1e-300, 1e300, "", "a", "background", "auto", "stable", "world", [], {}, [0], [[0, 0]]),
    *({"$delete": True}, {"$append": [1]}, {"include": "program.yaml"}, [0, 0, 0, 0], [1, 2], [2, 1], "cube", "bin"),
]


def _paths(value: Any, path: tuple = ()) -> list[tuple]:
    below = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(below_it for key, inner in below for below_it in _paths(inner, (*path, key)))]


def _changed(value: Any, path: tuple, to: Any, how: str) -> Any:
    if not path:
        return to
    copy: Any = dict(value) if isinstance(value, dict) else list(value)
    if len(path) == 1 and how == "drop":
        del copy[path[0]]
    elif len(path) == 1 and how == "twice" and isinstance(copy, list):
        copy.append(copy[path[0]])
    elif len(path) == 1 and how == "twice":
        copy[f"{path[0]}_deg"] = copy[path[0]]
    else:
        copy[path[0]] = _changed(value[path[0]], path[1:], to, how)
    return copy


@st.composite
def broken(draw: st.DrawFn) -> Any:
    """A program of the suite with one to three changes."""
    program = draw(st.sampled_from(PROGRAMS))
    for _ in range(draw(st.integers(1, 3))):
        path = draw(st.sampled_from(_paths(program)[1:] or [()]))
        program = _changed(program, path, draw(st.sampled_from(ODD)), draw(st.sampled_from(["set", "drop", "twice"])))
        if not isinstance(program, dict):
            return {}
    return program


@settings(max_examples=300, deadline=None)
@given(broken())
def test_a_broken_program_ends_in_findings_or_in_a_problem(program: Any):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.yaml"
        path.write_text(json.dumps(program))
        read = read_program(path)
        found = read.diagnostics
        if read.program is not None:
            lowered = lower(read.program, AssetLibrary(None), read.spans)
            found = (*found, *lowered.diagnostics)
            assert lowered.problems or any(d.severity == "error" for d in found)
        assert (read.program is None) == any(d.severity == "error" for d in read.diagnostics)
        assert all(d.where.file and d.where.line and d.headline for d in found)
