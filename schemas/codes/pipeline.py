"""Diagnostic codes of pipeline files; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

PIPELINE_CODES: dict[str, CodeInfo] = {
    "pipeline/unknown-key": CodeInfo(
        "error",
        "A key that this place of a pipeline does not take",
        "It would be ignored in silence, and the pipeline would do something else than its author thinks.",
        "correct it to one of the keys that the finding lists, or take it away",
    ),
    "pipeline/missing-key": CodeInfo(
        "error",
        "A key that this place of a pipeline needs is absent",
        "There is no value that could be assumed.",
        "write the key",
    ),
    "pipeline/invalid-value": CodeInfo(
        "error",
        "A value of a pipeline is of the wrong kind",
        "It has no meaning there.",
        "write a value as the finding says",
    ),
    "pipeline/illegal-order": CodeInfo(
        "error",
        "A section stands before what it is made from",
        "Parts come before assemblies, assemblies before rollouts: a pipeline is read from above in this order.",
        "move the section below those that the finding names",
    ),
    "pipeline/name-twice": CodeInfo(
        "error",
        "Two orders of one kind have the same name",
        "What refers to the name would mean either.",
        "give one of them another `name`",
    ),
    "pipeline/unnamed-order": CodeInfo(
        "error",
        "An order has no name",
        "Nothing can refer to it.",
        "write `name`, or the fragment's own (`scene`, `definition: {scene_type: ...}`, `task`)",
    ),
    "pipeline/unknown-name": CodeInfo(
        "error",
        "A name that no order above has",
        "There is nothing that it could refer to.",
        "correct it to one of the names that the finding lists, or write the order",
    ),
    "pipeline/unbound-role": CodeInfo(
        "error",
        "No object of the scene plays a role of the task",
        "The condition speaks of nothing, and could never hold or always would.",
        "tag an object of the scene, name one under `roles` of the task, or correct the role",
    ),
    "pipeline/ambiguous-role": CodeInfo(
        "error",
        "Several objects of the scene could play a role that takes one",
        "Which one is meant decides whether the task succeeds.",
        "name one under `roles` of the task, or use a condition that takes several objects",
    ),
    "pipeline/unmet-need": CodeInfo(
        "error",
        "A condition reads what the scene does not have",
        "No episode in this scene could be judged.",
        "choose an asset that has it, name another volume, surface or joint, or use another condition",
    ),
    "pipeline/unused-order": CodeInfo(
        "warning",
        "No assembly uses the order",
        "It is made for nothing, or an assembly is missing.",
        "take it away, or write an assembly that names it",
    ),
}
