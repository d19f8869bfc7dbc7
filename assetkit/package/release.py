"""Writes a finished draft as a self-contained package folder (USD, URDF twin, previews, record) and publishes it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

from assetkit.affordances.grasp_trials import grasp_lines
from assetkit.articulation.roles import group_of_joints, roles_with_joints
from assetkit.articulation.swept_volumes import with_swept_volumes
from assetkit.package.package import AddGrasps, AddPreviews, Package, WriteRecord, reread
from assetkit.package.record import read_record
from assetkit.package.write_twins import write_twins
from assetkit.stage import Acceptance, Appearance, Canonical, Draft, Interaction, Physics, Previews, Semantics, Tools
from assetkit.stage_log import StageLog
from jobs.durable import exchange, sync, sync_tree
from schemas.asset import AssetRecord, SemanticsSection, SourceSection
from schemas.diagnostics import Diagnostic, finding
from schemas.evidence import Evidence, declared, default
from schemas.package import GraspLines, PackageContent
from usdio.write.package import write_package
from usdio.write.source_names import source_names

UNKNOWN = "unknown"


def author(draft: Draft, tools: Tools) -> Package:
    """The package of a draft below the work folder: USD and URDF twin, without pictures and record.

    It is written unless it lies there, made of the same results. The twin is made from the body as re-read from the
    USD, so both hold the same numbers.
    """
    grasps = grasp_lines(draft.acceptance.affordances) if draft.acceptance else ()
    last = tools.last_package.find(_results(draft), grasps)
    if last is not None:
        return last
    folder = tools.work_dir / "package" / draft.asset_id
    shutil.rmtree(folder, ignore_errors=True)
    content = _content(draft, grasps)
    read_back = reread(write_package(content, folder))
    write_twins(read_back, content, folder)
    package = Package.on_disk(folder)
    tools.last_package.keep(package, _results(draft), grasps)
    return package


def with_grasps(package: Package, draft: Draft, grasps: GraspLines, tools: Tools) -> Package:
    """The package of a draft without grasps, with them."""
    if not grasps:
        return package
    changed = package.edited(AddGrasps(grasps))
    tools.last_package.keep(changed, _results(draft), grasps)
    return changed


def finish(draft: Draft, log: StageLog, tools: Tools) -> Package:
    """The package with previews and record.

    Acceptance has written it, unless that came from the store or judged another attempt last: then it is written here,
    the same bytes of the same draft.
    """
    images = draft[Previews].images | draft[Acceptance].images
    package = author(draft, tools).edited(AddPreviews(images))
    return package.edited(WriteRecord(_record(draft, log, package.hashes)))


def _results(draft: Draft) -> tuple[object, ...]:
    """All that the content of a package is made of, but for grasps."""
    results = (draft.canonicalize, draft.appearance, draft.semantics, draft.interaction, draft.recovery)
    return (draft.intake, *results, draft.physics, draft.previews)


def publish(folder: Path, target: Path) -> Diagnostic | None:
    """Move a finished package into place, or return a finding why not: only an older package is ever replaced.

    Its files are flushed to disk before. An older package is swapped with it in one step; where the file system cannot
    do that, a process that ends in between leaves the old package as a hidden `.old` folder.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.exists() and read_record(target) is None:
        return finding("asset/output-occupied", f"'{target.name}' in the output folder is not a package of Mana")
    old = target.with_name(f".{target.name}.old")
    shutil.rmtree(old, ignore_errors=True)
    sync_tree(folder)
    if target.exists() and exchange(folder, target):
        sync(target.parent)
        shutil.rmtree(folder, ignore_errors=True)
        return None
    if target.exists():
        target.rename(old)
    folder.rename(target)
    sync(target.parent)
    shutil.rmtree(old, ignore_errors=True)
    return None


def _content(draft: Draft, grasps: GraspLines) -> PackageContent:
    physics = draft[Physics]
    semantics = draft[Semantics].section
    metadata = draft.intake.model.metadata
    return PackageContent(
        asset_id=draft.asset_id,
        model=draft.model,
        shapes=physics.shapes,
        mass=physics.mass,
        contact=physics.contact,
        physical_material=physics.section.material.value,
        density_kgm3=physics.section.density_kgm3.value,
        category=semantics.category.value,
        qcode=semantics.qcode.value,
        license=metadata.get("license", UNKNOWN),
        author=metadata.get("author", UNKNOWN),
        source_file=draft.source_name,
        thumbnail_png=draft[Previews].images["thumbnail"],
        surfaces=physics.surfaces,
        shape_surfaces=physics.shape_surfaces,
        grasp_lines_m=grasps,
        parts=tuple(p.value for p in draft.interaction.parts) if draft.interaction else (),
        mechanism=draft[Canonical].mechanism,
        links=physics.links,
        filtered_pairs=physics.filtered_pairs,
    )


def _record(draft: Draft, log: StageLog, hashes: Mapping[str, str]) -> AssetRecord:
    source = draft.intake.model
    canonical = draft[Canonical]
    return AssetRecord(
        asset_id=draft.asset_id,
        outcome=log.outcome,
        source=SourceSection(
            format=draft.intake.format,
            files=draft.intake.files,
            meters_per_unit=canonical.meters_per_unit,
            up_axis=canonical.up_axis,
            license=_stated(source.metadata, "license"),
            author=_stated(source.metadata, "author"),
            generator=source.metadata.get("generator", ""),
            nodes=len(source.nodes),
            source_names=source_names(draft.model),
        ),
        geometry=canonical.section,
        appearance=draft.recovery.section if draft.recovery else draft[Appearance].section,
        semantics=_with_interaction(draft),
        parts=draft[Interaction].parts,
        affordances=draft[Acceptance].affordances,
        anchors=draft[Acceptance].anchors,
        joint_uses=with_swept_volumes(draft[Interaction].joint_uses, draft[Physics].swept),
        physics=draft[Physics].section,
        retopology=draft.retopology.section if draft.retopology else None,
        acceptance=draft[Acceptance].section,
        diagnostics=log.diagnostics,
        repairs=log.repairs,
        history=log.history,
        hashes=dict(hashes),
    )


def _with_interaction(draft: Draft) -> SemanticsSection:
    """The semantics of the draft, with the front that its parts indicate, and the group that its joints do; roles
    with those of its joints, without those that acceptance withdrew."""
    section, interaction = draft[Semantics].section, draft[Interaction]
    withdrawn = draft[Acceptance].withdrawn_roles
    roles = tuple(
        role for role in roles_with_joints(section.roles, interaction.joint_uses) if role.value not in withdrawn
    )
    group = group_of_joints(interaction.joint_uses) or section.interaction_group
    section = section.model_copy(update={"roles": roles, "interaction_group": group})
    front = interaction.front
    if front is None:
        return section
    return section.model_copy(update={"front": front.direction, "heading_symmetry": front.symmetry})


def _stated(metadata: dict[str, str], key: str) -> Evidence[str]:
    """License or author as the file or the user states it, else unknown."""
    return (
        declared(metadata[key], metadata.get(f"{key}_from", "source file")) if metadata.get(key) else default(UNKNOWN)
    )
