"""Resolve a reference found inside an asset, never leaving the asset's root."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote, urlsplit

from schemas.diagnostics import InvalidInput, Location, finding

UDIM = "<UDIM>"
_DRIVE = re.compile(r"^[a-zA-Z]:[\\/]|^\\\\")


def resolve_reference(uri: str, *, base: Path, root: Path, where: Location | None = None) -> Path | None:
    """The file a reference names, or None when no such file exists here or the text is no path at all.

    Percent-encoding, Windows separators and differing letter case are understood. `base` is the folder of the
    referring file. Paths of another machine (drive letters, UNC, `file://host`) cannot exist here: None, unopened.

    Raises InvalidInput (`asset/path-escape`) when the path, with symlinks followed, lies outside `root`, and
    (`asset/remote-reference`) for network addresses. Nothing outside `root` is opened or listed.
    """
    try:
        return _resolve(uri, base=base, root=root, where=where)
    except (ValueError, OSError, RuntimeError):
        return None  # An over-long name, a lone surrogate, a broken IPv6 address, a circle of links: no such file.


def tile_references(uri: str) -> tuple[str, ...]:
    """The references that a name with `<UDIM>` expands to, tiles 1001 to 1100; another name is its own only reference.

    Source: the UDIM convention of Mari, as UsdUVTexture and MaterialX take it over.
    """
    if UDIM not in uri:
        return (uri,)
    return tuple(uri.replace(UDIM, str(number)) for number in range(1001, 1101))


def expected_path(uri: str, *, base: Path, root: Path) -> str | None:
    """Where below `root` an absent reference would lie (forward slashes), None when it names no such place."""
    try:
        path = (base / unquote(uri.strip()).replace("\\", "/")).resolve()
        return path.relative_to(root.resolve()).as_posix()
    except (ValueError, OSError, RuntimeError):
        return None


def _resolve(uri: str, *, base: Path, root: Path, where: Location | None) -> Path | None:
    text = unquote(uri.strip())
    scheme = urlsplit(text).scheme.lower()
    if scheme in {"http", "https", "ftp", "s3", "omniverse"}:
        raise InvalidInput(
            finding("asset/remote-reference", f"'{uri}' is a network address; nothing is fetched", where=where)
        )
    if scheme == "file":
        rest = text[len("file:") :]
        if rest.startswith("///") or not rest.startswith("//"):
            text = rest[2:] if rest.startswith("///") else rest
            text = text[1:] if _DRIVE.match(text[1:]) else text
        else:
            return None  # file://host/...: another machine's disk
    if _DRIVE.match(text) or not text or "\x00" in text:
        return None
    candidate = base / text.replace("\\", "/")
    resolved = Path(candidate).resolve()
    if not resolved.is_relative_to(root.resolve()):
        raise InvalidInput(
            finding(
                "asset/path-escape",
                f"'{uri}' leads out of the asset's folder",
                where=where,
                value=uri,
                bound=root.name,
            )
        )
    if resolved.is_file():
        return resolved
    return _ignoring_case(resolved, root.resolve())


def _ignoring_case(path: Path, root: Path) -> Path | None:
    """The file below `root` whose path equals `path` but for letter case, if there is exactly one way to it."""
    current = root
    for part in path.relative_to(root).parts:
        if not current.is_dir():
            return None
        exact = current / part
        if exact.exists():
            current = exact
            continue
        similar = sorted(p for p in current.iterdir() if p.name.lower() == part.lower())
        if len(similar) != 1:
            return None
        current = similar[0]
    resolved = current.resolve()
    return resolved if resolved.is_file() and resolved.is_relative_to(root) else None
