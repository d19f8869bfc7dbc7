"""Read a scene program: text and includes to its model, or to everything that is wrong with it, in one run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath

from scenec.ir.derivation_cache import Memo
from scenec.source.checks import check_program
from scenec.source.include import load
from scenec.source.incremental_parse import Pieces
from scenec.source.merge import settled
from scenec.source.tree import Spans
from scenec.source.validate import validate
from schemas.diagnostics import Diagnostic, any_error
from schemas.scene.program import SceneProgram


@dataclass(frozen=True)
class Read:
    """A program and where its values stand. `program` is None when a diagnostic is an error."""

    program: SceneProgram | None
    spans: Spans
    diagnostics: tuple[Diagnostic, ...]


def read_program(
    path: FilePath, root: FilePath | None = None, pieces: Pieces | None = None, memo: Memo | None = None
) -> Read:
    """The program that begins in the file `path`; includes stay inside `root`, by default its folder.

    `pieces` and `memo` keep what is parsed and validated for the next time. Diagnostics name files relative to `root`,
    and are all of one phase: the text, then keys and values, then names.
    """
    inside = (root or path.parent).resolve()
    tree, found = load(path, inside) if pieces is None else load(path, inside, pieces.parse)
    target = path.resolve()
    name = target.relative_to(inside).as_posix() if target.is_relative_to(inside) else path.name
    if tree is None:
        return Read(None, Spans(None, name), found)
    rules: list[Diagnostic] = []
    tree = settled(tree, rules)
    spans = Spans(tree, name)
    found = (*found, *rules)
    if any_error(found):
        return Read(None, spans, found)
    program, more = validate(tree, spans, memo)
    found = (*found, *more)
    if program is not None:
        found = (*found, *check_program(program, spans))
    return Read(None if any_error(found) else program, spans, found)
