"""What the rest of the pipeline knows of a source format: names, first bytes, habit of units, and its reader.

Each reader exports its `SourceFormat`; `assetkit.readers.by_format` lists them, and every other table derives from it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from assetkit.sources.source_file import SourceFile
from schemas.model import Model
from schemas.outcome import Outcome

Reader = Callable[[SourceFile], Outcome[Model]]


@dataclass(frozen=True)
class Signature:
    """First bytes of a file, what they are in words, and the extensions under which they are expected.

    Without `extensions` they are expected under all of their format.
    """

    content: str
    first_bytes: bytes
    extensions: tuple[str, ...] = ()


@dataclass(frozen=True)
class SourceFormat:
    """One format of source files.

    name         as records and options of the pipeline have it.
    extensions   lower case, with dot.
    read         the model of a file; raises InvalidInput for what cannot be read.
    magic        first bytes by which a file under a wrong extension is recognised.
    syntax       the text syntax that the format builds on; its files begin like all of that syntax.
    referring    extensions under which a file is text that names other files, which then count as its parts.
    marks        text that a file must begin with (in its first 4096 bytes) to be taken in a walk, by extension: others
                 share the extension.
    unit_habit   "cad": written by CAD and for printing, in millimetres, with the walls that a part has.
    """

    name: str
    extensions: tuple[str, ...]
    read: Reader
    magic: tuple[Signature, ...] = ()
    syntax: Literal["XML", "JSON"] | None = None
    referring: tuple[str, ...] = ()
    marks: tuple[tuple[str, str], ...] = ()
    unit_habit: Literal["none", "cad"] = "none"
