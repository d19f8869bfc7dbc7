"""Reads a scene program: resolves includes, validates and checks; returns the model, or all findings of one phase."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath

from scenec.ir.derivation_cache import DerivationCache
from scenec.source.checks import check_program
from scenec.source.distractors import check_distractors, with_distractors
from scenec.source.language import SECTIONS
from scenec.source.paired_materials.library import with_pairs
from scenec.source.validate import validate
from schemas.diagnostics import Diagnostic, any_error
from schemas.scene.program import SceneProgram
from source.include import read_tree
from source.incremental_parse import IncrementalParser
from source.parse import parse
from source.tree import Spans


@dataclass(frozen=True)
class ReadResult:
    """A program, the locations of its values, and findings. `program` is None when a finding is an error."""

    program: SceneProgram | None
    spans: Spans
    diagnostics: tuple[Diagnostic, ...]


def read_program(
    path: FilePath,
    root: FilePath | None = None,
    parser: IncrementalParser | None = None,
    derivations: DerivationCache | None = None,
) -> ReadResult:
    """The program whose first file is `path`; includes must stay inside `root`, by default its folder.

    `parser` and `derivations` keep parsed and validated parts for the next call. Diagnostics name files relative to
    `root` and are all of one phase: the text, then keys and values, then names.
    """
    inside = (root or path.parent).resolve()
    parse_file = parse if parser is None else parser.parse
    tree, diagnostics = read_tree(path, inside, parse_file, sections=SECTIONS)
    if tree is None:  # perhaps for a path that cannot be resolved
        return ReadResult(None, Spans(None, path.name), diagnostics)
    name = path.resolve().relative_to(inside).as_posix()
    spans = Spans(tree, name)
    if any_error(diagnostics):
        return ReadResult(None, spans, diagnostics)
    program, more = validate(tree, spans, derivations)
    diagnostics = (*diagnostics, *more)
    if program is not None:
        diagnostics = (*diagnostics, *check_distractors(program, spans))
        program, spans = with_distractors(program, spans)
        if not any_error(diagnostics):
            diagnostics = (*diagnostics, *check_program(program, spans))
    if program is None or any_error(diagnostics):
        return ReadResult(None, spans, diagnostics)
    return ReadResult(with_pairs(program), spans, diagnostics)
