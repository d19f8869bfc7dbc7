"""One source asset on disk, as the readers see it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from schemas.diagnostics import Location
from schemas.references import resolve_reference


@dataclass(frozen=True)
class SourceFile:
    """The main file of an asset and the folder no reference may leave."""

    path: Path
    root: Path

    @property
    def relative(self) -> str:
        """The file's path below the root, with forward slashes; used in diagnostics."""
        return self.path.resolve().relative_to(self.root.resolve()).as_posix()

    def resolve(self, uri: str, *, where: Location | None = None, base: Path | None = None) -> Path | None:
        """The file `uri` names, or None when absent; see `schemas.references.resolve_reference`."""
        return resolve_reference(uri, base=base or self.path.parent, root=self.root, where=where)
