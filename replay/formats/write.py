"""Variants on disk: the recording in its own format with its streams bit for bit, and `variant.json` beside.

The layout is the same for every format: `<folder>/recording/...` and `<folder>/variant.json`.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py

from jobs.cache import write_atomically
from replay.episode import Episode
from replay.formats.digests import recording_files, stream_digests
from replay.formats.hdf5 import child, opened, text
from replay.formats.mesh_archive import MESHES
from schemas.episode import EPISODE_FILE
from schemas.replay import VARIANT_FILE, Variant

RECORDING = "recording"


def write_variant(episode: Episode, variant: Variant, folder: Path) -> Variant:
    """The variant with `part`, `recording` and `source_sha256` filled in, as it was written into `folder`."""
    target = folder / RECORDING
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    source, recording = episode.source, RECORDING
    if source.is_dir():
        for file in recording_files(source, episode.part):
            copy = target / file.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, copy)
    else:
        recording = f"{RECORDING}/{source.name}"
        write_hdf5_part(source, episode.part, folder / recording)
    filled = variant.model_copy(
        update={
            "part": episode.part,
            "recording": recording,
            "source_sha256": stream_digests(source, episode.part),
        }
    )
    write_atomically(folder / VARIANT_FILE, (filled.model_dump_json(indent=1) + "\n").encode())
    return filled


def write_hdf5_part(source: Path, part: str, target: Path) -> None:
    """A file with one recording of another: its group as HDF5 copies it, with the attributes of the groups above.

    A model file beside that it names comes along, and the archive of meshes; mesh files stay where they are.
    """
    with opened(source) as old, h5py.File(target, "w") as new:
        _copy_attributes(old, new)
        above, _, name = part.rpartition("/")
        holder = new.require_group(above) if above else new
        if above:
            _copy_attributes(child(old, above, source.name), holder)
        group = child(old, part, source.name)
        old.copy(group, holder, name=name)
        model = text(group.attrs.get("model_file", ""))
        if "total" in getattr(holder, "attrs", {}) and "num_samples" in group.attrs:
            holder.attrs["total"] = group.attrs["num_samples"]  # robomimic: samples of all demonstrations in the file
    beside = [model] if model and not model.lstrip().startswith("<") else []
    files = [source.parent / name for name in (*beside, EPISODE_FILE)] + [source.with_suffix(".json")]
    files += [f for f in (source.parent / MESHES, source.parent.parent / MESHES) if f.is_file()][:1]
    for file in files:
        if file.is_file() and not file.is_symlink() and file.resolve().is_relative_to(source.parent.parent.resolve()):
            shutil.copyfile(file, target.parent / file.name)


def _copy_attributes(old: h5py.Group | h5py.File, new: h5py.Group | h5py.File) -> None:
    for name, value in old.attrs.items():
        new.attrs[name] = value
