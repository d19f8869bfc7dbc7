"""Write a variant as a USD stage: the recording at its own stamps, with the inserted objects."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from replay.recording.episode import Episode
from replay.recording.kinematics import link_poses
from replay.recording.recorded_numbers import invalid_recording
from replay.verification.check_output import read_variant, read_variant_episode
from replay.verification.inserted_bodies import as_packaged
from runtime_plan.materials import is_paired, with_material
from schemas.replay.documents import VARIANT_FILE, Inserted, Variant
from schemas.scene.compiled import PlacedObject
from schemas.scene.program import PairedMaterial
from schemas.scene.samples import SampledLighting
from usdio.write.episode import InsertedObject, TimedBody, TimedCamera, write_context, write_motion, write_replay
from usdio.write.package import USD_FOLDER
from usdio.write.sample import SampleEdit
from usdio.write.scene import PACKAGES


def compose(folder: Path, packages: Path | None, meshes: Path | None = None) -> Path:
    """Write the stage of the variant in `folder` and copy the packages that it uses beside; returns `replay.usda`.

    `packages` may be None where they are beside already. Raises InvalidInput.
    """
    variant = read_variant(folder)
    return write_stage(folder, variant, read_variant_episode(folder, variant, meshes), packages)


def write_stage(folder: Path, variant: Variant, episode: Episode, packages: Path | None) -> Path:
    """As `compose`, for a variant and a recording that have been read."""
    library = packages if packages is not None else folder / PACKAGES
    lighting = SampledLighting.model_validate(variant.lights) if variant.lights else None
    for one in variant.inserted:
        _check_package(one, library)
    write_context(folder, [_put_in(one, variant, library) for one in variant.inserted], lighting, library)
    write_motion(folder, episode.t_s, list(timed_bodies(episode)), timed_cameras(episode))
    about: dict[str, str | int] = {
        "episode": variant.episode,
        "source": variant.source,
        "seed": variant.seed,
        "variant": variant.number,
    }
    return write_replay(folder, episode.t_s, about)


def _check_package(one: Inserted, library: Path) -> None:
    """Raises InvalidInput where its package is absent, or a path that leads out of the library."""
    if one.package is None:
        return
    if not (library / one.package).resolve().is_relative_to(library.resolve()):
        raise invalid_recording(
            "replay/path-escape", f"package '{one.package}' is not below the folder of packages", VARIANT_FILE
        )
    if not any((library / one.package / USD_FOLDER).glob("*.usda")):
        raise invalid_recording(
            "replay/missing-file", f"package '{one.package}' is not in the folder of packages", VARIANT_FILE
        )


def timed_bodies(episode: Episode) -> Iterator[TimedBody]:
    """Poses of the links of all robots, of objects and of fixtures."""
    for robot in episode.robots:
        X_WL = link_poses(robot, robot.q, robot.X_WR)
        for number, link in enumerate(robot.links):
            yield TimedBody("Robots", robot.name, link.name, link.shapes, X_WL[:, number])
    for body in episode.objects:
        yield TimedBody("Objects", "", body.name, body.shapes, body.X_WB)
    for fixture in episode.fixtures:
        yield TimedBody("Fixtures", "", fixture.name, fixture.shapes, fixture.X_WB[None])


def timed_cameras(episode: Episode) -> list[TimedCamera]:
    """The recorded cameras."""
    return [TimedCamera(c.name, c.X_WC, c.fovy_rad, c.width_px, c.height_px) for c in episode.cameras]


def _put_in(one: Inserted, variant: Variant, library: Path) -> InsertedObject:
    item = PlacedObject(
        id=one.name,
        asset_id=one.asset_id,
        package=one.package,
        position_m=one.position_m,
        quat_wxyz=one.quat_wxyz,
        scale=one.scale,
        parent=one.support,
        anchor="",
        prisms=(),
        primitive=one.primitive,
        mass_kg=one.mass_kg,
    )
    material = variant.materials.get(one.material)
    return InsertedObject(item, None if material is None else _edit(one, material, library))


def _edit(one: Inserted, material: PairedMaterial, library: Path) -> SampleEdit:
    """The edit for a material of an object that never moves: appearance and contact, no mass."""
    own = as_packaged(one, library)
    contact = with_material(own.body, own.density_kgm3, material).contact if is_paired(material) else None
    return SampleEdit(one.name, material=material, contact=contact)
