"""Reads pushes: `<id>.pose`, `<id>.tip` and `<id>.force` tables, or all of them as arrays of one `<id>.npz`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from schemas.arrays import FloatArray
from simgap.recording.reading.columns import Column, take
from simgap.recording.reading.tables import Table, unreadable
from simgap.recording.recording import Push

PARTS = ("pose", "tip", "force")


def part_of(stem: str) -> tuple[str, str]:
    """Trial id and part of a file's stem; the part is empty when one file holds them all."""
    head, _, tail = stem.rpartition(".")
    return (head, tail) if head and tail in PARTS else (stem, "")


def push_trial(trial_id: str, tables: Mapping[str, tuple[str, Table]], columns: Sequence[Column]) -> Push:
    """One push from its parts (part name to file name and table).

    Raises InvalidInput (`gap/missing-column`, `gap/unreadable-table`): a part is absent, or the pose table has not the
    two rows before and after.
    """
    taken: dict[str, FloatArray] = {}
    for column in columns:
        part = column.name.split("_")[0] if column.name.split("_")[0] in PARTS else "pose"
        file, table = tables.get(part) or tables.get("") or next(iter(tables.values()))
        if part not in tables and "" not in tables:
            raise unreadable(file, f"'{trial_id}' has no {part} table for '{column.name}'")
        taken[column.name] = take(table, column, file)
    quats = taken["q_wxyz"] if "q_wxyz" in taken else np.roll(taken["q_xyzw"], 1, axis=1)
    pose_file = (tables.get("pose") or next(iter(tables.values())))[0]
    if len(taken["p"]) != 2 or len(quats) != 2:
        raise unreadable(pose_file, f"a push has two poses, before and after; the table has {len(taken['p'])}")
    tip_p = taken["tip_p"]
    force = taken.get("force", np.zeros((0, 2)))
    return Push(
        id=trial_id,
        before_p=taken["p"][0],
        before_quat_wxyz=quats[0],
        after_p=taken["p"][1],
        after_quat_wxyz=quats[1],
        tip_t_s=_same_length(taken["tip_t"], tip_p, pose_file),
        tip_p=tip_p,
        tip_quat_wxyz=taken.get("tip_q_wxyz", np.full((len(tip_p), 4), np.nan)),
        force_t_s=_same_length(taken.get("force_t", np.zeros(0)), force, pose_file),
        force=force,
    )


def _same_length(t_s: FloatArray, values: FloatArray, file: str) -> FloatArray:
    if len(t_s) != len(values):
        raise unreadable(file, f"{len(t_s)} stamps for {len(values)} rows")
    return t_s
