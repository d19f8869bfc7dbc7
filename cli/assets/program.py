"""Programs of the user that a flag names, as one would type them: their words, and a hash of their files."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path
from typing import NamedTuple

import typer

from jobs.cache import content_key, file_sha256


class StatedProgram(NamedTuple):
    """Words of a command, files with whole paths; `digest` is the hash of these files."""

    command: tuple[str, ...]
    digest: str


def program_stated(command: str, flag: str) -> StatedProgram:
    """The program that `flag` names. Raises typer.BadParameter for what cannot run."""
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint=flag) from None
    if not words or shutil.which(words[0]) is None:
        raise typer.BadParameter("names no program that can be run", param_hint=flag)
    # The worker may stand in another folder than the user.
    whole = tuple(str(Path(word).absolute()) if Path(word).is_file() else word for word in words)
    return StatedProgram(whole, content_key([file_sha256(Path(word)) for word in whole if Path(word).is_file()]))
