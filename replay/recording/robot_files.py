"""Reads robot descriptions of a recording: refusals get codes of recordings, with the description's own as cause."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from formats import parse_mjcf, read_mjcf, read_urdf
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.robot_description import RobotDescription

# Other codes of descriptions mean a value that cannot be right: replay/invalid-value.
_CODES = {
    "robot/missing-file": "replay/missing-file",
    "robot/unreadable": "replay/unreadable",
    "robot/xml-declarations": "replay/unreadable",
    "robot/path-escape": "replay/path-escape",
    "robot/missing-mesh": "replay/missing-mesh",
    "robot/unsupported-shape": "replay/unsupported-model",
    "robot/global-coordinates": "replay/unsupported-model",
}


def recorded_urdf(path: Path, root: Path) -> RobotDescription:
    """The URDF of a recording. Nothing outside `root` is opened. Raises InvalidInput."""
    with _refused_as_recording():
        return read_urdf(path, root)


def recorded_mjcf(path: Path, root: Path) -> RobotDescription:
    """The MJCF model of a recording. Nothing outside `root` is opened. Raises InvalidInput."""
    with _refused_as_recording():
        return read_mjcf(path, root)


def recorded_mjcf_text(text: bytes, path: Path) -> RobotDescription:
    """The same of text that a recording at `path` holds; it may include files beside. Raises InvalidInput."""
    with _refused_as_recording():
        return parse_mjcf(text, path.name, path.parent)


def as_recording_finding(cause: Diagnostic) -> Diagnostic:
    """The finding of a recording that a finding of its description causes."""
    code = _CODES.get(cause.code, "replay/invalid-value")
    return finding(
        code, cause.headline, where=cause.where, value=cause.value, bound=cause.bound, unit=cause.unit, because=(cause,)
    )


@contextmanager
def _refused_as_recording() -> Iterator[None]:
    try:
        yield
    except InvalidInput as refused:
        raise InvalidInput(as_recording_finding(refused.diagnostic)) from None
