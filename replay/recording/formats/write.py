"""Writing of variants: a copy of the recording in its own format, streams bit for bit, and `variant.json` beside it.

The layout is the same for every format: `<folder>/recording/...` and `<folder>/variant.json`.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py

from jobs.cache import write_atomically
from replay.recording.description.from_description import read_description
from replay.recording.episode import Episode
from replay.recording.files.hdf5 import child, open_hdf5, text
from replay.recording.files.mesh_archive import MESHES
from replay.recording.formats.digests import recording_bytes, recording_files, stream_digests
from replay.recording.formats.episode_folder import is_table
from replay.recording.formats.maniskill import json_of_part
from schemas.replay.documents import VARIANT_FILE, Variant
from schemas.replay.episode import EPISODE_FILE, MeshShape

RECORDING = "recording"


def write_variant(episode: Episode, variant: Variant, folder: Path) -> Variant:
    """The variant with `part`, `recording`, `scene` and `source_sha256` filled in, as it was written into `folder`."""
    target = folder / RECORDING
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    source, recording = episode.source, RECORDING
    if source.is_dir():
        for file in recording_files(source, episode.part):
            copy = target / file.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(recording_bytes(source, file))
    elif is_table(source):
        recording = f"{RECORDING}/{source.name}"
        shutil.copyfile(source, folder / recording)
    else:
        recording = f"{RECORDING}/{source.name}"
        write_hdf5_part(source, episode.part, folder / recording)
    filled = variant.model_copy(
        update={
            "part": episode.part,
            "recording": recording,
            "scene": str(episode.description) if episode.description else variant.scene,
            "source_sha256": stream_digests(source, episode.part),
        }
    )
    write_atomically(folder / VARIANT_FILE, (filled.model_dump_json(indent=1) + "\n").encode())
    return filled


def write_hdf5_part(source: Path, part: str, target: Path) -> None:
    """A file with one recording of another: its group as HDF5 copies it, with the attributes of the groups above.

    What it names beside comes along (model, description), and the archive of meshes; mesh files of models stay.
    """
    with open_hdf5(source) as old, h5py.File(target, "w") as new:
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
    named = [model] if model and not model.lstrip().startswith("<") else []
    if (source.parent / EPISODE_FILE).is_file():
        description = read_description(source.parent / EPISODE_FILE)
        bodies = (*description.objects, *description.fixtures)
        named += [EPISODE_FILE, *(robot.model for robot in description.robots)]
        named += [shape.file for body in bodies for shape in body.shapes if isinstance(shape, MeshShape)]
    for name in dict.fromkeys(named):
        _copy_inside(source.parent, name, target.parent)
    entry = json_of_part(source, part)
    if entry is not None:
        target.with_suffix(".json").write_bytes(entry)
    for folder in (source.parent, source.parent.parent):
        if (folder / MESHES).is_file():
            _copy_inside(folder, MESHES, target.parent)
            break


def _copy_inside(folder: Path, name: str, target: Path) -> None:
    """Copy a file of a folder to the same place below another; nothing from outside."""
    file = folder / name
    if file.is_file() and file.resolve().is_relative_to(folder.resolve()) and ".." not in Path(name).parts:
        copy = target / file.relative_to(folder)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)


def _copy_attributes(old: h5py.Group | h5py.File, new: h5py.Group | h5py.File) -> None:
    for name, value in old.attrs.items():
        new.attrs[name] = value
