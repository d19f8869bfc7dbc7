"""Reads what a task is judged from: state logs, or recorded episodes, whose contacts are then computed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from schemas.diagnostics import InvalidInput, Location, finding
from schemas.files import array_files
from schemas.task.logged_scene import LOG_SUFFIX, LoggedScene


def logged_scenes(path: Path, meshes: Path | None = None) -> Iterator[LoggedScene]:
    """Every log of a path: a state log, or all episodes of a recording in a format that replay reads.

    Raises InvalidInput.
    """
    if path.name.endswith(LOG_SUFFIX):
        yield _stored(path)
        return
    from replay.recording.formats.read import read_episodes
    from replay.state_log import state_log

    for episode in read_episodes(path, meshes):
        name = f"{path.name}/{episode.part}" if episode.part else path.name
        log, scene = state_log(episode)
        yield _sound(LoggedScene(name, log, scene), path)


def _stored(path: Path) -> LoggedScene:
    where = Location(file=path.name)
    try:
        logged = array_files.load(LoggedScene, path)
    except OSError as error:
        raise InvalidInput(finding("task/invalid-log", f"cannot read it: {error.strerror}", where=where)) from None
    except ValueError as error:
        raise InvalidInput(finding("task/invalid-log", str(error).splitlines()[0], where=where)) from None
    return _sound(logged, path)


def _sound(logged: LoggedScene, path: Path) -> LoggedScene:
    if faults := logged.log.faults():
        where = Location(file=path.name)
        raise InvalidInput(finding("task/invalid-log", f"{logged.name}: {'; '.join(faults)}", where=where))
    return logged
