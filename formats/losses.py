"""What a format cannot express of a description: refusals, and losses that the writer reports."""

from __future__ import annotations

from typing import NamedTuple

from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.robot_description import RobotDescription, SourceLine


class WrittenDescription(NamedTuple):
    """The text of a file, and a warning for everything in the model that it does not hold."""

    data: bytes
    lost: tuple[Diagnostic, ...] = ()


def loss(headline: str, source: SourceLine) -> Diagnostic:
    """A warning: the mechanism is the same, a number or a name of it is not in the file."""
    return finding("robot/not-expressible", headline, where=source.location, severity=Severity.WARNING)


def not_expressible(headline: str, source: SourceLine) -> InvalidInput:
    """The exception for what would be another mechanism without it."""
    return InvalidInput(finding("robot/not-expressible", headline, where=source.location))


def unread_losses(description: RobotDescription) -> list[Diagnostic]:
    """One loss for each kind of element that was read as text."""
    first = {element.tag: element for element in reversed(description.unread)}
    return [loss(f"<{tag}> is not written", element.source) for tag, element in reversed(first.items())]
