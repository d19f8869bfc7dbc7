"""Reads the subject of a measurement: its files and the names and types of its joints."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from formats import read_urdf
from schemas.diagnostics import Diagnostic, InvalidInput, finding
from schemas.measurement import Joint, MeasurementSpec, Subject
from simgap.recording.reading.folder import inside
from simgap.recording.reading.urdf import SubjectModel, movable_joints, read_description, subject_model
from simgap.recording.reading.yaml_text import YamlDocument

INERTIA_ROUNDING = 1e-6  # share by which a point mass written with seven digits may fall short of its own product


class JointInfo(NamedTuple):
    """A joint's name, and whether it turns (rad) rather than slides (m)."""

    name: str
    turns: bool


def subject_files(root: Path, subject: Subject, document: YamlDocument) -> tuple[Path, ...]:
    """Every file that the subject names; a package is the folder's files in order.

    Raises InvalidInput (`gap/path-escape`, `gap/missing-file`).
    """
    files: list[Path] = []
    for key in ("mesh", "urdf", "package"):
        relative = getattr(subject, key)
        if relative is None:
            continue
        path = inside(root, relative, document.place(("subject", key)))
        files += sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
    return tuple(files)


def subject_joints(root: Path, subject: Subject, document: YamlDocument) -> tuple[JointInfo, ...]:
    """The subject's movable joints, in the order in which it lists them.

    Raises InvalidInput (`gap/unreadable-subject`, `gap/path-escape`, `gap/missing-file`).
    """
    if subject.joints:
        return tuple(JointInfo(j.name, j.type == "revolute") for j in subject.joints)
    if subject.urdf is not None:
        place = document.place(("subject", "urdf"))
        return _urdf_joints(inside(root, subject.urdf, place), root, document)
    if subject.package is not None:
        place = document.place(("subject", "package"))
        twins = sorted(inside(root, subject.package, place).glob("export/*.urdf"))
        return _urdf_joints(twins[0], root, document) if twins else ()
    return ()


def subject_findings(spec: MeasurementSpec, document: YamlDocument) -> tuple[Diagnostic, ...]:
    """Errors for missing fields that a simulation of this kind needs, and for repeated joint names."""
    subject, where = spec.subject, document.place(("subject",), of_key=True)
    findings: list[Diagnostic] = []
    if spec.kind == "free_body" and not (subject.box or subject.mesh or subject.urdf or subject.package):
        findings.append(finding("gap/missing-key", "a free body needs one of box, mesh, urdf, package", where=where))
    if spec.kind == "free_body" and (subject.box or subject.mesh) and subject.mass_kg is None:
        findings.append(finding("gap/missing-key", "'subject.mass_kg' is not given", where=where))
    if spec.kind == "mechanism" and not (subject.joints or subject.urdf or subject.package):
        findings.append(finding("gap/missing-key", "a mechanism needs joints, urdf or package", where=where))
    if spec.kind == "tracking" and not (subject.urdf or subject.package):
        findings.append(finding("gap/missing-key", "a tracked robot needs urdf or package", where=where))
    if spec.kind in ("impact", "push") and subject.mass_kg is None:
        findings.append(finding("gap/missing-key", "'subject.mass_kg' is not given", where=where))
    if spec.kind == "impact" and subject.inertia_kgm2 is None:
        findings.append(finding("gap/missing-key", "'subject.inertia_kgm2' is not given", where=where))
    names = [joint.name for joint in subject.joints]
    for k, joint in enumerate(subject.joints):
        place = document.place(("subject", "joints", k))
        findings += _inertia_findings(joint, k, document)
        if joint.name in names[:k]:
            findings.append(finding("gap/invalid-value", f"two joints are called '{joint.name}'", where=place))
    return tuple(findings)


def _inertia_findings(joint: Joint, k: int, document: YamlDocument) -> list[Diagnostic]:
    """Errors for the joint `k` of the table: no inertia, or less than its load alone has."""
    load = joint.gravity_load.inertia_kgm2 if joint.gravity_load is not None else 0.0
    inertia = joint.mass_kg if joint.type == "prismatic" else joint.inertia_kgm2 or load
    if not inertia:
        key = "mass_kg" if joint.type == "prismatic" else "inertia_kgm2"
        text = f"joint '{joint.name}' is {joint.type}: it needs {key}"
        return [finding("gap/missing-key", text, where=document.place(("subject", "joints", k)))]
    if joint.type == "prismatic" or inertia >= load * (1.0 - INERTIA_ROUNDING):
        return []
    text = (
        f"joint '{joint.name}' has an inertia of {inertia:.6g} kg m2 about its axis; its load alone has "
        f"mass_kg * com_distance_m^2 = {load:.6g} kg m2"
    )
    place = document.place(("subject", "joints", k, "inertia_kgm2"), of_key=True)
    return [finding("gap/inertia-below-load", text, where=place, value=inertia, bound=load, unit="kg m2")]


def read_subject(subject: Subject, root: Path) -> SubjectModel:
    """The model of a subject given as `urdf` or `package` (its URDF twin). Raises ValueError with the reason."""
    if subject.urdf is not None:
        return subject_model(read_description(root / subject.urdf, root), root)
    twins = sorted((root / (subject.package or "")).glob("export/*.urdf"))
    if subject.package is None or not twins:
        raise ValueError("the subject has neither a URDF nor a package with one in export/")
    return subject_model(read_description(twins[0], root), root)


def _urdf_joints(path: Path, root: Path, document: YamlDocument) -> tuple[JointInfo, ...]:
    where = document.place(("subject", "urdf"))
    try:
        description = read_urdf(path, root)
    except InvalidInput as refused:
        cause = refused.diagnostic
        headline = f"{cause.where}: {cause.headline}"
        raise InvalidInput(finding("gap/unreadable-subject", headline, where=where, because=(cause,))) from None
    return tuple(JointInfo(j.name, j.kind != "prismatic") for j in movable_joints(description))
