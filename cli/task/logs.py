"""Reads what a task is judged from: state logs, or recorded episodes, whose contacts are then computed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from schemas.diagnostics import InvalidInput, Location, finding
from schemas.files import array_files
from schemas.task.logged_scene import LOG_SUFFIX, LoggedScene


def log_files(paths: Sequence[Path]) -> dict[Path, str]:
    """State logs and recordings, those below folders too, each with a prefix that sets namesakes apart."""
    from replay.run import distinct_prefixes, recordings_below

    files: list[Path] = []
    for path in paths:
        below = sorted(path.glob(f"*{LOG_SUFFIX}")) if path.is_dir() else []
        files += below or ([path] if path.name.endswith(LOG_SUFFIX) else list(recordings_below(path)))
    return distinct_prefixes(files)


def logged_scenes(path: Path, prefix: str = "", meshes: Path | None = None) -> Iterator[LoggedScene]:
    """Every log of a file: a state log, or all episodes of a recording in a format that replay reads.

    Raises InvalidInput.
    """
    if path.name.endswith(LOG_SUFFIX):
        yield _sound(replace(_stored(path), name=prefix + path.name.removesuffix(LOG_SUFFIX)), path)
        return
    from replay.recording.formats.read import read_episodes
    from replay.state_log import state_log

    for episode in read_episodes(path, meshes):
        name = f"{prefix}{path.name}/{episode.part}" if episode.part else prefix + path.name
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
    return logged


def _sound(logged: LoggedScene, path: Path) -> LoggedScene:
    if faults := logged.log.faults():
        where = Location(file=path.name)
        raise InvalidInput(finding("task/invalid-log", f"{logged.name}: {'; '.join(faults)}", where=where))
    return logged
