"""A package folder as a value: its files by digest, its re-read content, and the edits that it allows.

A package is written once per attempt (`assetkit.package.release`); after that it changes only by the edits of `Edit`.
What is read back from its USD files is kept by the digest of their bytes, so that equal bytes are read once per
process and changed bytes are never mistaken for them. Validators and gate do not use this: they open the files.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from assetkit.package.record import RECORD
from assetkit.package.write_urdf import rewrite_urdf
from jobs.cache import content_key, file_sha256
from schemas.asset import AssetRecord
from schemas.package import GraspLines
from schemas.physics import Contact, MassProperties
from usdio.reread.body import RereadPackage, reread_package
from usdio.write.grasps import add_grasps
from usdio.write.rewrite_physics import rewrite_physics

PREVIEWS, EXTENSION = "previews", "extension.json"
_LAYERS = (".usd", ".usda", ".usdc")
_KEPT = 4  # re-read contents: those of the attempt at hand and of its neighbours
_reread: dict[str, RereadPackage] = {}


@dataclass(frozen=True)
class AddGrasps:
    """Lines of grasps into a package that has none."""

    lines_m: GraspLines


@dataclass(frozen=True)
class RewritePhysics:
    """Mass properties and contacts in USD and URDF; `contact` None keeps those of the materials, whose densities are
    multiplied by `density_factor`. `urdf_contact` are further values for PyBullet's `<contact>`.
    """

    mass: MassProperties
    contact: Contact | None
    density_factor: float
    urdf_contact: Mapping[str, float]


@dataclass(frozen=True)
class AddPreviews:
    """PNG pictures by name."""

    images: Mapping[str, bytes]


@dataclass(frozen=True)
class AddExtension:
    """The bytes of `extension.json`."""

    data: bytes


@dataclass(frozen=True)
class WriteRecord:
    """The record, whose `hashes` are those of the package before this edit."""

    record: AssetRecord


Edit = AddGrasps | RewritePhysics | AddPreviews | AddExtension | WriteRecord


@dataclass(frozen=True)
class Package:
    """A package folder, named as its asset, and the SHA-256 of each file by its path below it, sorted."""

    folder: Path
    hashes: Mapping[str, str] = field(repr=False)

    @classmethod
    def on_disk(cls, folder: Path) -> Package:
        """The package in `folder` as it is now."""
        files = (p for p in sorted(folder.rglob("*")) if p.is_file())
        return cls(folder, {p.relative_to(folder).as_posix(): file_sha256(p) for p in files})

    @property
    def main_file(self) -> Path:
        """The main USD file."""
        return self.folder / "usd" / f"{self.folder.name}.usda"

    @property
    def urdf_file(self) -> Path:
        """The URDF twin."""
        return self.folder / "export" / f"{self.folder.name}.urdf"

    @cached_property
    def digest(self) -> str:
        """One hash over the names and bytes of all files."""
        return content_key(dict(self.hashes))

    def is_intact(self) -> bool:
        """Whether the folder still holds the same files with the same bytes."""
        return Package.on_disk(self.folder).digest == self.digest

    def edited(self, edit: Edit) -> Package:
        """The package after `edit`, which is carried out in its folder. Raises OSError when writing fails."""
        changed = {p.relative_to(self.folder).as_posix(): file_sha256(p) for p in self._carry_out(edit)}
        return Package(self.folder, dict(sorted({**self.hashes, **changed}.items())))

    def _carry_out(self, edit: Edit) -> tuple[Path, ...]:
        """The files that `edit` wrote."""
        match edit:
            case AddGrasps(lines_m):
                return (add_grasps(self.main_file, lines_m),)
            case RewritePhysics(mass, contact, density_factor, urdf_contact):
                layers = rewrite_physics(self.main_file, mass, contact, density_factor)
                content = reread(self.main_file)
                rewrite_urdf(content.body, self.urdf_file, urdf_contact, content.shape_contacts)
                return (*layers, self.urdf_file)
            case AddPreviews(images):
                (self.folder / PREVIEWS).mkdir(exist_ok=True)
                files = {self.folder / PREVIEWS / f"{name}.png": data for name, data in images.items()}
            case AddExtension(data):
                files = {self.folder / EXTENSION: data}
            case WriteRecord(record):
                files = {self.folder / RECORD: f"{record.model_dump_json(indent=1)}\n".encode()}
        for path, data in files.items():
            path.write_bytes(data)
        return tuple(files)


class LastPackage:
    """The package that lies in a work folder, and the results that it was written from."""

    def __init__(self) -> None:
        self._results: tuple[object, ...] = ()
        self._grasps: GraspLines = ()
        self._package: Package | None = None

    def keep(self, package: Package, results: tuple[object, ...], grasps: GraspLines) -> None:
        """Remember `package`, made of the objects `results` with these grasps."""
        self._package, self._results, self._grasps = package, results, grasps

    def find(self, results: tuple[object, ...], grasps: GraspLines) -> Package | None:
        """The package made of the very same objects with equal grasps, if its files are intact."""
        same = len(results) == len(self._results) and all(a is b for a, b in zip(results, self._results, strict=True))
        usable = self._package is not None and same and grasps == self._grasps and self._package.is_intact()
        return self._package if usable else None


def reread(main_file: Path) -> RereadPackage:
    """What a package holds, read back from the USD files as they are now; equal bytes are read once per process.

    Raises InvalidInput (`asset/package-invalid`) as `usdio.reread.body.reread_body` does.
    """
    layers = (p for p in sorted(main_file.parent.rglob("*")) if p.suffix in _LAYERS and p.is_file())
    digest = content_key(main_file.name, {p.relative_to(main_file.parent).as_posix(): file_sha256(p) for p in layers})
    if digest not in _reread:
        while len(_reread) >= _KEPT:
            _reread.pop(next(iter(_reread)))
        _reread[digest] = reread_package(main_file)
    return _reread[digest]
