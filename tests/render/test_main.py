"""The entry point of all drawing processes: every row of its table draws what its request holds; others are refused."""

from __future__ import annotations

import inspect
import typing
from pathlib import Path
from pkgutil import resolve_name

import pytest

from render.__main__ import REQUESTS, main


@pytest.mark.parametrize("what", REQUESTS)
def test_a_row_names_a_request_and_the_function_that_takes_it(what: str) -> None:
    kind, draw = (resolve_name(name) for name in REQUESTS[what])
    (parameter,) = inspect.signature(draw).parameters
    assert typing.get_type_hints(draw)[parameter] is kind


@pytest.mark.parametrize("arguments", [[], ["previews"], ["statues", "request.npz"], ["mode", "a.npz", "b.npz"]])
def test_other_arguments_get_the_usage(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    usage = capsys.readouterr().err
    assert all(word in usage for word in ("python -m render", *REQUESTS))


def test_a_request_of_another_kind_is_unreadable(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "request.npz"
    file.write_bytes(b"no archive")
    assert main(["motion", str(file)]) == 2
    assert "cannot read" in capsys.readouterr().err
