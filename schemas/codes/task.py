"""Diagnostic codes of task files and of logs that tasks are judged from; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

TASK_CODES: dict[str, CodeInfo] = {
    "task/unknown-key": CodeInfo(
        "error",
        "A key that this place does not take",
        "It would be ignored in silence, and the task would mean something else than its author thinks.",
        "correct it to one of the keys that the finding lists, or take it away",
    ),
    "task/missing-key": CodeInfo(
        "error",
        "A key that this place needs is absent",
        "There is no value that could be assumed.",
        "write the key",
    ),
    "task/invalid-value": CodeInfo(
        "error",
        "A value is of the wrong kind or out of range",
        "It has no meaning there.",
        "write a value as the finding says; docs/reference/predicates.md has the parameters of every predicate",
    ),
    "task/unknown-predicate": CodeInfo(
        "error",
        "A condition names a predicate that does not exist",
        "The stage could never be judged.",
        "take a name of docs/reference/predicates.md",
    ),
    "task/invalid-graph": CodeInfo(
        "error",
        "Nodes and edges are no task graph",
        "A node that waits for itself, for a node that does not exist, or that stands there twice can never be judged.",
        "correct the ids of the nodes or the ends of the edges",
    ),
    "task/degrees-suspected": CodeInfo(
        "error",
        "An angle is most likely written in degrees",
        "Angles are radians; a tolerance of 15 rad would always hold.",
        "write radians, or the key with `_deg` at its end",
    ),
    "task/points-normalised": CodeInfo(
        "info",
        "The points of the nodes are not ten together",
        "They were scaled exactly to ten; a benchmark needs them written so.",
        "write points that are ten together",
    ),
    "task/points-not-ten": CodeInfo(
        "error",
        "The points of a benchmark task are not ten together",
        "Scores of tasks could not be compared.",
        "write points that are ten together",
    ),
    "task/unbound-role": CodeInfo(
        "error",
        "No object of the scene plays a role of the task",
        "The condition speaks of nothing, and could never hold or always would.",
        "tag an object of the scene, name one under `roles`, or correct the role to one that the finding lists",
    ),
    "task/ambiguous-role": CodeInfo(
        "error",
        "Several objects of the scene could play a role that takes one",
        "Which one is meant decides whether the task succeeds.",
        "name one under `roles`, or use a condition that takes several objects",
    ),
    "task/state-missing": CodeInfo(
        "error",
        "The log or the scene lacks what a condition reads",
        "The task cannot be judged from it; neither success nor failure would be true.",
        "record what the finding names, or use another condition",
    ),
    "task/invalid-log": CodeInfo(
        "error",
        "A log is no consistent record of states",
        "Its arrays do not fit together, or hold values that cannot be.",
        "record it again",
    ),
}
