"""Root layers among several USD files: those that no other file names as sublayer, reference or payload."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pxr import Sdf, Tf

from usdio.quiet import quiet


def root_files(files: Sequence[Path]) -> list[Path]:
    """The files that no other one of them names as sublayer, reference or payload; all when they name each other.

    A file that cannot be opened counts as an asset, so that reading it reports why.
    """
    named: set[Path] = set()
    with quiet():
        for file in files:
            named |= {(file.parent / path).resolve() for path in _dependencies(file)} - {file.resolve()}
    return [file for file in files if file.resolve() not in named] or list(files)


def _dependencies(file: Path) -> list[str]:
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(file), metadataOnly=False)
    except Tf.ErrorException:
        return []
    return [path for path in layer.GetCompositionAssetDependencies() if path] if layer else []
