"""Diagnostic codes of runtime plans and of samples; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

PLAN_CODES: dict[str, CodeInfo] = {
    "plan/missing-file": CodeInfo(
        "error",
        "A plan or a file of samples is absent",
        "There is nothing to sample, or nothing to verify.",
        "correct the path; `mana scene compile` writes `plan.json` beside the scene",
    ),
    "plan/unreadable": CodeInfo(
        "error",
        "The file is no plan",
        "It is no JSON, or it was cut off, or it is another kind of file.",
        "compile the scene again; a plan is written as a whole or not at all",
    ),
    "plan/unknown-version": CodeInfo(
        "error",
        "The plan has a version that this Mana does not read",
        "Fields may mean something else there, so that samples could be wrong without a sign of it.",
        "compile the scene again with this Mana, or use the Mana that wrote the plan",
    ),
    "plan/invalid-value": CodeInfo(
        "error",
        "A value of the plan is missing or of the wrong kind",
        "The plan was edited or damaged; what it promised is no longer known to hold.",
        "compile the scene again",
    ),
    "plan/inconsistent": CodeInfo(
        "error",
        "Parts of the plan do not fit together",
        "A name or a number in it leads nowhere, or an interval ends before it begins: it was edited or damaged.",
        "compile the scene again",
    ),
    "plan/missing-package": CodeInfo(
        "error",
        "A package that the plan needs is absent",
        "Without it the samples can be drawn and verified, but not realised.",
        "name the folder of packages that the scene was compiled with",
    ),
    "plan/changed-package": CodeInfo(
        "error",
        "A package is not the one that the plan was made from",
        "Cells were proven for the geometry it had; with another one, samples may collide.",
        "compile the scene again with the packages as they are now",
    ),
    "plan/unknown-choice": CodeInfo(
        "error",
        "A restriction names what the plan does not have",
        "A misspelt name would silently leave everything, or nothing.",
        "take a name that `mana plan inspect PLAN --json` lists",
    ),
    "plan/nothing-left": CodeInfo(
        "error",
        "A restriction leaves nothing of the plan",
        "No combination of variants has an asset left for each of its things.",
        "allow more, or add variants to the program and compile it again",
    ),
    "plan/unreadable-samples": CodeInfo(
        "error",
        "The file holds no samples",
        "It is no JSON, a value is of the wrong kind, or it names things that the plan does not have.",
        "draw the samples again: `mana plan sample`",
    ),
    "plan/other-plan": CodeInfo(
        "error",
        "The samples are those of another plan",
        "They were drawn from a plan with other bytes, so that this one says nothing about them.",
        "name the plan that they were drawn from, or draw them again",
    ),
    "plan/no-view": CodeInfo(
        "error",
        "No drawn camera shows what it must",
        "Cameras are drawn anew until each object is seen with the pixels demanded; in this scene no try did.",
        "widen the ranges of the camera, or ask for fewer pixels: `cameras` in the program",
    ),
}
