"""Opens the composed USD stage of a package from its current files on disk."""

from __future__ import annotations

from pathlib import Path

from pxr import Tf, Usd

from schemas.diagnostics import Diagnostic, InvalidInput, Location, finding


def open_stage(main_file: Path) -> Usd.Stage:
    """The composed stage of a package, all payloads loaded, as the files are now.

    USD keeps layers in a process-wide registry as long as anyone holds them; `Reload` makes sure that a file rewritten
    since is read again. Raises InvalidInput (`asset/package-invalid`) when the file cannot be opened.
    """
    try:
        stage = Usd.Stage.Open(str(main_file))
    except Tf.ErrorException as error:
        raise InvalidInput(_unreadable(main_file)) from error
    if stage is None:
        raise InvalidInput(_unreadable(main_file))
    stage.Reload()
    return stage


def _unreadable(main_file: Path) -> Diagnostic:
    return finding("asset/package-invalid", "the USD file cannot be opened", where=Location(file=main_file.name))
