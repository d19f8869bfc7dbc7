"""Subtask labels of frames from the order of completions."""

from __future__ import annotations

from collections.abc import Sequence


def label_stretches(events: Sequence[tuple[int, str]]) -> tuple[tuple[int, int, str], ...]:
    """(first, last, node) for completions (frame, node) in order: frames after the previous completion up to this one.

    Frame 0 and frames after the last completion have no label; of completions in one frame the first takes it.
    """
    stretches: list[tuple[int, int, str]] = []
    before = 0
    for frame, node in events:
        if frame > before:
            stretches.append((before + 1, frame, node))
            before = frame
    return tuple(stretches)


def frame_labels(stretches: Sequence[tuple[int, int, str]], frames: int) -> tuple[str | None, ...]:
    """The label of each frame."""
    labels: list[str | None] = [None] * frames
    for first, last, node in stretches:
        labels[first : last + 1] = [node] * (last + 1 - first)
    return tuple(labels)
