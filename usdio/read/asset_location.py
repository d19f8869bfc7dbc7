"""Location of a USD file, on disk or inside a USDZ package, and the only resolution of references from it."""

from __future__ import annotations

import posixpath
import zipfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import unquote

from pxr import Ar

from schemas.diagnostics import Location
from schemas.files.references import expected_path, resolve_reference
from usdio.read.usdz import check_package


@dataclass(frozen=True)
class AssetLocation:
    """A file below `root`; `inner` names an entry when `path` is a USDZ package.

    `visited` collects the files that references resolve to, `missing` the paths below the root that do not exist;
    locations resolved from one another share both.
    """

    path: Path
    root: Path
    inner: str = ""
    visited: set[Path] = field(default_factory=set, compare=False, repr=False)
    missing: set[str] = field(default_factory=set, compare=False, repr=False)

    @property
    def identifier(self) -> str:
        """The layer identifier of the file in OpenUSD."""
        return Ar.JoinPackageRelativePath([str(self.path), self.inner]) if self.inner else str(self.path)

    @property
    def name(self) -> str:
        """The file name, without folders."""
        return posixpath.basename(self.inner) or self.path.name

    @property
    def extension(self) -> str:
        """Lower-case extension without the dot."""
        return posixpath.splitext(self.name)[1][1:].lower()

    def where(self, *, line: int | None = None, column: int | None = None, prim: str | None = None) -> Location:
        """A location in this file, relative to the root."""
        relative = self.path.relative_to(self.root).as_posix()
        return Location(
            file=f"{relative}[{self.inner}]" if self.inner else relative, line=line, column=column, prim=prim
        )

    def read(self, limit: int = -1) -> bytes:
        """The file's bytes, at most `limit` when that is not negative."""
        if not self.inner:
            with self.path.open("rb") as file:
                return file.read(limit)
        with zipfile.ZipFile(self.path) as package, package.open(self.inner) as entry:
            return entry.read(limit)

    def resolve(self, uri: str, *, prim: str | None = None) -> AssetLocation | None:
        """The file that a reference in this file names, or None when there is none.

        Raises InvalidInput as `schemas.files.references.resolve_reference` and, for USDZ, `check_package` do.
        """
        where = self.where(prim=prim)
        outer, inner = Ar.SplitPackageRelativePathOuter(uri) if Ar.IsPackageRelativePath(uri) else (uri, "")
        folder = self.path.parent / posixpath.dirname(self.inner)
        try:
            target_path = resolve_reference(outer, base=folder, root=self.root, where=where)
        except OSError:  # A name too long for the file system names nothing on it.
            return None
        if self.inner:
            entry = self._entry(outer)
            return replace(self, inner=entry) if entry and not inner else None
        if target_path is None:
            expected = expected_path(outer, base=folder, root=self.root)
            self.missing.update([expected] if expected else [])
            return None
        self.visited.add(target_path)
        target = replace(self, path=target_path, inner="")
        return _enter(target, inner) if target_path.suffix.lower() == ".usdz" else target

    def _entry(self, uri: str) -> str | None:
        """The package entry named by `uri`: relative to this layer's folder, else to the package's root."""
        text = unquote(uri.strip()).replace("\\", "/")
        with zipfile.ZipFile(self.path) as package:
            names = package.namelist()
        for start in dict.fromkeys((posixpath.dirname(self.inner), "")):
            entry = posixpath.normpath(posixpath.join(start, text))
            if entry in names:
                return entry
            similar = sorted(n for n in names if n.lower() == entry.lower())
            if len(similar) == 1:
                return similar[0]
        return None


def _enter(package: AssetLocation, inner: str = "") -> AssetLocation | None:
    """The layer `inner`, or else the root layer, of a checked USDZ package; None when it has no such entry."""
    first = check_package(package.path, where=package.where())
    if not inner:
        return replace(package, inner=first)
    with zipfile.ZipFile(package.path) as archive:
        return replace(package, inner=inner) if inner in archive.namelist() else None


def locate_asset(path: Path, root: Path) -> AssetLocation:
    """The location of an asset's main file; for a USDZ package its root layer. Raises as `check_package`."""
    location = AssetLocation(path.resolve(), root.resolve())
    return (_enter(location) if location.path.suffix.lower() == ".usdz" else None) or location
