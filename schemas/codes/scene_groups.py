"""Diagnostic codes of scene groups that place their members relative to one another; part of the table in
`schemas.codes`."""

from __future__ import annotations

from schemas.codes.code_info import CodeInfo

SCENE_GROUP_CODES: dict[str, CodeInfo] = {
    "scene/stack-unsteady": CodeInfo(
        "error",
        "A stack may fall within the poses that it allows",
        "A plan draws every pose within the alignment. At some of them the middle of a thing, or of one above it, is "
        "not over what carries it.",
        "take a smaller `alignment`, a broader thing below, or fewer things",
    ),
    "scene/grid-size": CodeInfo(
        "error",
        "The members of a grid do not fill its cells",
        "A grid has one member for each cell, or one that is copied into all of them; else it would be open which "
        "cells stay empty.",
        "name as many members as rows times columns, or a single one",
    ),
}
