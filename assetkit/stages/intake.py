"""Stage 1, intake: any source file into the internal model, screened for what cannot become an asset."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from assetkit.options import Options
from assetkit.readers.collada.read import read_dae
from assetkit.readers.gltf.read import read_gltf
from assetkit.readers.obj.read import read_obj
from assetkit.readers.ply.read import read_ply
from assetkit.readers.stl import read_stl
from assetkit.readers.usd import read_usd
from assetkit.sources.discover import PLANNED_FORMATS, Candidate
from assetkit.sources.sibling_files import sibling_statements
from assetkit.sources.source_file import SourceFile, refusal
from assetkit.sources.split_objects import split_objects
from assetkit.stage import Intake
from geom.mesh.topology import is_all_degenerate, is_triangle_soup, observe
from jobs.cache import file_sha256
from schemas import asset
from schemas.diagnostics import Diagnostic, InvalidInput, Severity, finding
from schemas.model import Model
from schemas.outcome import Outcome, Repair

NAME, VERSION = "intake", 2
MAX_FILE_BYTES = 2**30

READERS: dict[str, Callable[[SourceFile], Outcome[Model]]] = {
    "obj": read_obj,
    "glb": read_gltf,
    "gltf": read_gltf,
    "stl": read_stl,
    "ply": read_ply,
    "dae": read_dae,
    "usd": read_usd,
    "usdz": read_usd,
}


@dataclass(frozen=True)
class IntakeResult:
    """The objects found in one source file, with what was noticed on the way."""

    objects: tuple[Intake, ...]
    diagnostics: tuple[Diagnostic, ...]
    repairs: tuple[Repair, ...]
    review: bool


def take_in(candidate: Candidate, options: Options) -> IntakeResult:
    """Read and screen one source; fatal findings come back as error diagnostics and no objects."""
    try:
        return _take_in(candidate, options)
    except InvalidInput as refused:
        return IntakeResult((), (refused.diagnostic,), (), review=False)


def _take_in(candidate: Candidate, options: Options) -> IntakeResult:
    _require_readable(candidate)
    outcome = READERS[candidate.format](candidate.file)
    diagnostics = list(outcome.diagnostics)
    if outcome.value is None or outcome.failed:
        return IntakeResult((), tuple(diagnostics), outcome.repairs, review=False)
    siblings = sibling_statements(candidate.file) if outcome.value.meters_per_unit.source == "default" else ()
    model = replace(
        outcome.value,
        meshes=tuple(m for m in outcome.value.meshes if len(m.triangles)),
        hints=(*outcome.value.hints, *siblings),
        metadata={**outcome.value.metadata, **_stated(options)},
    )
    _require_surface(model)
    files = _files_read(candidate.file)
    models = split_objects(model)
    review = any(d.code == "asset/articulated-source" for d in diagnostics)
    if len(models) > 1:
        too_many = len(models) > options.max_objects
        diagnostics.append(_several(len(models), options.max_objects, too_many=too_many))
        if too_many:
            models, review = (model,), True
    low, high = (f([f(m.points, axis=0) for m in model.meshes], axis=0) for f in (np.min, np.max))
    extent = (float(high[0] - low[0]), float(high[1] - low[1]), float(high[2] - low[2]))
    folders = _folders(candidate.file)
    objects = tuple(Intake(candidate.format, files, m, extent, folders[0], folders, len(models) - 1) for m in models)
    return IntakeResult(objects, tuple(diagnostics), outcome.repairs, review)


def _folders(source: SourceFile) -> tuple[str, ...]:
    """Names of the folders from the file up to its root, nearest first."""
    root, own = source.root.absolute(), source.path.absolute().parent
    return tuple(f.name for f in (own, *own.parents) if f == own or f.is_relative_to(root))


def _stated(options: Options) -> dict[str, str]:
    """What the user says about the origin, with where it was said; it overrules the file."""
    said = {"license": options.license, "author": options.author}
    return {
        k: v for key, value in said.items() if value for k, v in ((key, value), (f"{key}_from", options.origin(key)))
    }


def _require_readable(candidate: Candidate) -> None:
    source = candidate.file
    if (unusable := refusal(source)) is not None:
        raise InvalidInput(unusable)
    if not source.path.resolve().is_relative_to(source.root.resolve()):
        raise InvalidInput(
            finding("asset/path-escape", "the file itself lies outside its root, perhaps through a link", bound="root")
        )
    suffix = candidate.file.path.suffix.lower()
    size = candidate.file.path.stat().st_size
    if suffix in PLANNED_FORMATS:
        raise InvalidInput(finding("asset/format-unsupported-yet", f"{suffix} files are not read yet", value=suffix))
    if candidate.format not in READERS:
        raise InvalidInput(
            finding(
                "asset/format-unsupported",
                f"'{suffix or candidate.file.path.name}' is not a supported file type",
                value=suffix,
                bound=", ".join(sorted(READERS)),
            )
        )
    if size > MAX_FILE_BYTES:
        raise InvalidInput(
            finding("asset/resource-limit", "the file is too large", value=size, bound=MAX_FILE_BYTES, unit="bytes")
        )


def _require_surface(model: Model) -> None:
    """Refuse models without a usable surface."""
    if not model.meshes:
        raise InvalidInput(finding("asset/empty-geometry", "the file holds no triangles"))
    points = np.concatenate([m.points for m in model.meshes])
    if not np.isfinite(points).all():
        raise InvalidInput(finding("asset/nonfinite-vertices", "a coordinate is NaN or infinite after transforms"))
    starts = np.cumsum([0, *(len(m.points) for m in model.meshes)])[:-1]
    triangles = np.concatenate([m.triangles + s for m, s in zip(model.meshes, starts, strict=True)])
    topology = observe(points, triangles, "merged")
    if is_all_degenerate(topology):
        raise InvalidInput(
            finding("asset/degenerate-geometry", "every face has zero area", value=topology.degenerate_faces, bound=0)
        )
    if is_triangle_soup(topology):
        raise InvalidInput(
            finding(
                "asset/triangle-soup",
                f"{topology.triangles} triangles form {topology.components} unconnected pieces",
                value=topology.components,
                unit="pieces",
            )
        )


def _several(count: int, limit: int, *, too_many: bool) -> Diagnostic:
    return finding(
        "asset/several-objects",
        f"the file holds {count} separate objects"
        + ("; a person must say which belong together" if too_many else "; each becomes a package of its own"),
        value=count,
        bound=limit,
        unit="objects",
        severity=Severity.WARNING if too_many else Severity.INFO,
    )


def _files_read(source: SourceFile) -> tuple[asset.SourceFile, ...]:
    """The main file and every file a reference led to, with their hashes."""
    root = source.root.resolve()
    paths = sorted({source.path.resolve(), *source.visited})
    return tuple(
        asset.SourceFile(path=p.relative_to(root).as_posix(), sha256=file_sha256(p), bytes=p.stat().st_size)
        for p in paths
    )
