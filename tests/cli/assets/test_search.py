"""`mana assets search` names the nearest known words, each once."""

from __future__ import annotations

from pathlib import Path

from typer.testing import CliRunner

from assetkit.library import catalog
from cli.main import app


def test_a_category_with_a_slip_gets_each_known_word_once(tmp_path: Path) -> None:
    catalog.rebuild(tmp_path)
    command = ["assets", "search", str(tmp_path), "mug", "--category", "botle"]
    result = CliRunner().invoke(app, command, env={"COLUMNS": "200"})
    assert result.exit_code == 2
    assert "did you mean bottle" in result.output
    near = result.output.split("did you mean ")[1].split("?")[0].split(" or ")
    assert len(near) == len(set(near)) > 1
