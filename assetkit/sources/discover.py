"""Finds the source assets among files and folders: file, format, id, and the root that no reference may leave."""

from __future__ import annotations

import os
import re
import unicodedata
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from assetkit.package.record import RECORD
from assetkit.readers.by_format import FORMAT_OF, FORMATS
from assetkit.sources.source_file import SourceFile
from jobs.cache import content_key, file_sha256

# Extensions of models that are reported where Mana does not read them; other files in a folder are passed over.
MODEL_EXTENSIONS = {".fbx", ".3mf", ".3ds", ".step", ".stp", ".iges", ".igs", ".off", ".x3d", ".wrl", ".abc", ".sdf"}
_TEXT_WITH_REFERENCES = {e for row in FORMATS for e in row.referring}
_MARKS = {extension: text for row in FORMATS for extension, text in row.marks}
_SEARCHES_FOLDERS = {".urdf", ".xml", ".mjcf"}  # These name meshes relative to a mesh folder or a package.
_HAS_GEOMETRY_OR_ARC = re.compile(
    r"def (?:Mesh|Cube|Sphere|Cylinder|Cone|Capsule|Plane)|references =|payload =|subLayers ="
)
_REFERENCE_SCAN_BYTES = 4_000_000
_MAX_SLUG = 78  # Names of files and folders are made from it, and they may have 255 bytes.
_NAMED = "|".join(re.escape(extension) for extension in FORMAT_OF)
_NAME_END = re.compile(rf"(?:{_NAMED})(?![a-z0-9])", re.IGNORECASE)
_NAME_BREAK = re.compile(r"""[\s"'@<>|*?=\0]""")
_MAX_FILE_NAME = 1024  # Longer names exist in no file system; a data URI of megabytes is no name.


@dataclass(frozen=True)
class SourceAsset:
    """One asset to ingest. `given` is its path as the user gave it, joined with the path below it."""

    given: str
    file: SourceFile
    format: str
    asset_id: str


def discover(sources: Sequence[Path], *, root: Path | None = None, out: Path | None = None) -> tuple[SourceAsset, ...]:
    """Every asset among `sources`, in the order of their paths; a path that does not exist raises FileNotFoundError.

    An explicit file is one asset whatever its type. A folder is walked (hidden folders, packages of Mana and `out` left
    out, links not followed); files that another source refers to are its parts, unsupported model files are kept so
    that they are reported. A file reached twice counts once, as first given.
    """
    given_and_root: dict[Path, tuple[Path, Path]] = {}  # real path -> (file as given, root)
    for source in sources:
        if source.is_dir():
            pairs = _walk(source, root, out)
        elif source.exists():
            pairs = [(source, root or _package_root(source.parent))]
        else:
            raise FileNotFoundError(source)
        for path, folder in pairs:
            given_and_root.setdefault(path.absolute().parent.resolve() / path.name, (path, folder))
    unique = sorted((str(path), path, folder) for path, folder in given_and_root.values())
    ids = _asset_ids({path: folder for _, path, folder in unique})
    return tuple(
        SourceAsset(printable(given), SourceFile(path, folder), format_of(path), ids[path])
        for given, path, folder in unique
    )


def format_of(path: Path) -> str:
    """The format by extension, or the bare extension when Mana does not read it."""
    suffix = path.suffix.lower()
    return FORMAT_OF.get(suffix) or suffix.lstrip(".") or "none"


def slug(stem: str) -> str:
    """A stable identifier: at most 80 ASCII letters, digits, underscores, never empty, never starting with a digit."""
    ascii_ = unicodedata.normalize("NFKD", stem).encode("ascii", "ignore").decode()
    text = re.sub(r"[^A-Za-z0-9]+", "_", ascii_).strip("_").lower()[:_MAX_SLUG].rstrip("_")
    return f"a_{text}" if not text or text[0].isdigit() else text


def printable(name: str) -> str:
    """A file name as text that can be written down: bytes that are no UTF-8 become escapes."""
    return os.fsencode(name).decode("utf-8", "backslashreplace")


def _asset_ids(roots: Mapping[Path, Path]) -> dict[Path, str]:
    """The ids of files with their roots: the slug of the stem; where several share it, each gets 6 hex of its content,
    and of its path if that is equal. Files of formats that are not read, of which no package is made, take no slug from
    others.
    """
    paths = list(roots)
    slugs = {path: slug(path.stem) for path in paths}
    are_read = {p for p in paths if p.suffix.lower() in FORMAT_OF}
    clashes, claims = Counter(slugs.values()), Counter(slugs[p] for p in are_read)
    shared = {p for p, s in slugs.items() if (claims if p in are_read else clashes)[s] > 1}
    contents = {p: _content(p, roots[p]) for p in paths if p in shared}
    ids = {p: f"{s}-{contents[p][:6]}" if p in contents else s for p, s in slugs.items()}
    twins = Counter(ids.values())
    top = os.path.commonpath([p.absolute().parent for p in paths]) if paths else ""
    return {
        p: i if twins[i] == 1 else f"{slugs[p]}-{content_key(contents[p], os.path.relpath(p.absolute(), top))[:6]}"
        for p, i in ids.items()
    }


def _content(path: Path, root: Path) -> str:
    """The file's hash; of its name when it cannot be read or a link leads out of its root, which intake will report."""
    if path.is_symlink() and not _lies_below(path, root):
        return content_key(printable(path.name))
    try:
        return file_sha256(path) if path.is_file() else content_key(printable(path.name))
    except OSError:
        return content_key(printable(path.name))


def _walk(folder: Path, root: Path | None, out: Path | None) -> list[tuple[Path, Path]]:
    """The sources below a folder, each with the largest folder that holds it and no other source."""
    known = {*FORMAT_OF, *MODEL_EXTENSIONS}
    left_out = out.resolve() if out else None
    files: list[Path] = []
    for parent, folders, names in os.walk(folder):
        here = Path(parent)
        folders[:] = [
            f
            for f in folders
            if not f.startswith(".") and not _is_package(here / f) and (here / f).resolve() != left_out
        ]
        files += [here / n for n in names if Path(n).suffix.lower() in known and not n.startswith(".")]
    files.sort()
    outside = {
        f for f in files if f.is_symlink() and not _lies_below(f, root or folder)
    }  # not opened; intake reports it
    files = [
        f for f in files if f in outside or (mark := _MARKS.get(f.suffix.lower())) is None or mark in _head(f, 4096)
    ]
    parts = _parts([f for f in files if f not in outside])
    sources = [f for f in files if f not in parts]
    below = Counter(folder for f in sources if f in outside or not _is_material_library(f) for folder in f.parents)
    return [(f, root or _asset_root(f, folder, below)) for f in sources]


def _lies_below(link: Path, top: Path) -> bool:
    """Whether the file that a link leads to lies below `top`; True for links to nothing, which can do no harm."""
    try:
        return link.resolve(strict=True).is_relative_to(top.resolve())
    except (OSError, RuntimeError):
        return True


def _is_package(folder: Path) -> bool:
    return (folder / RECORD).is_file() and (folder / "usd").is_dir()


def _parts(files: Sequence[Path]) -> set[Path]:
    """The files that another file needs. In a reference cycle no file is a part: all its members are reported.

    Nothing is parsed here, only names are looked for: a false match costs one asset its own row in the report, so
    only existing files at the named place count.
    """
    by_name: dict[str, list[Path]] = {}
    for file in files:
        by_name.setdefault(file.name.lower(), []).append(file)
    naming = [f for f in files if f.suffix.lower() in _TEXT_WITH_REFERENCES]
    references = [(file, target) for file in naming for target in _named_by(file, by_name)]
    if not references:
        return set()
    import networkx as nx  # Takes longer to load than most folders to walk.

    condensed = nx.condensation(nx.DiGraph(references))
    return {f for n in condensed for f in condensed.nodes[n]["members"] if condensed.in_degree(n) > 0}


def _named_by(file: Path, by_name: dict[str, list[Path]]) -> set[Path]:
    """The known files that the text of `file` names."""
    searches = file.suffix.lower() in _SEARCHES_FOLDERS
    targets: set[Path] = set()
    for token in _names_in(_head(file)):
        parts = PurePosixPath(token.replace("\\", "/").removeprefix("//")).parts  # Blender: relative to the file
        named = Path(os.path.normpath(file.parent.joinpath(*parts)))
        for target in by_name.get(parts[-1].lower(), ()):
            if target != file and (target == named or (searches and target.is_relative_to(file.parent))):
                targets.add(target)
    return targets


def _names_in(text: str) -> set[str]:
    """File names in `text`: a known extension and all before it, back to the last quote, blank or bracket."""
    names: set[str] = set()
    for match in _NAME_END.finditer(text):
        before = _NAME_BREAK.split(text[max(0, match.start() - _MAX_FILE_NAME) : match.start()])[-1]
        if before:
            names.add(before + match[0])
    return names


def _is_material_library(path: Path) -> bool:
    """Whether a text USD layer holds materials only: reported as empty, but no reason to split an asset's folder."""
    if path.suffix.lower() != ".usda":
        return False
    text = _head(path)
    return "def Material" in text and not _HAS_GEOMETRY_OR_ARC.search(text)


def _head(path: Path, size: int = _REFERENCE_SCAN_BYTES) -> str:
    """The beginning of a file as text; empty when it cannot be read, which intake will report."""
    try:
        if not path.is_file():  # A pipe would keep us waiting.
            return ""
        with path.open("rb") as file:
            return file.read(size).decode("utf-8", "ignore")
    except OSError:
        return ""


def _package_root(folder: Path) -> Path:
    """The nearest folder upwards that holds a `package.xml`, else the folder itself."""
    return next((p for p in (folder, *folder.absolute().parents) if (p / "package.xml").is_file()), folder)


def _asset_root(file: Path, top: Path, sources_below: Counter[Path]) -> Path:
    """The asset's root: upwards from the file, within `top`, as long as no other source lies below."""
    package = _package_root(file.parent)
    if (package / "package.xml").is_file():
        return package
    folder = file.parent
    while folder != top and sources_below[folder.parent] == 1:
        folder = folder.parent
    return folder
