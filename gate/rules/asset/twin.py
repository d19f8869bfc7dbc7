"""Rule: the USD states the mass properties that the package's URDF twin states."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from gate.rules.rule import Rule
from gate.subject import Body, Subject
from gate.subject.inertial import mass_centre, stated_inertia
from gate.subject.values import STATED_TOLERANCE, at, format_numbers
from schemas.arrays import FloatArray
from schemas.codes.code_info import DiagnosticCode
from schemas.diagnostics import Diagnostic, Location, finding

CODE = DiagnosticCode(
    "asset/gate-twin",
    "The USD and its URDF twin state different mass properties",
    "The same object would move differently in two simulators; one of the files was changed after release.",
    "ingest the source again, or carry the change over into both",
)


class TwinLink(NamedTuple):
    """A link of a URDF file: mass (kg), mass centre (3,) m, tensor (3, 3) kg m2 about it, collision shapes."""

    mass_kg: float
    centre_m: FloatArray
    inertia_kgm2: FloatArray
    shapes: int


def check(subject: Subject) -> Iterator[Diagnostic]:
    """In a package with one URDF file below `export`: a finding per value that differs, and per missing link.

    One body is the one link, whatever its name; of several each has the link of its name.
    """
    files = sorted((subject.package_folder / "export").glob("*.urdf")) if subject.released else []
    if len(files) != 1 or not subject.active_bodies:
        return
    where = Location(file=f"export/{files[0].name}")
    try:
        links = _read(files[0])
    except (OSError, ValueError, AttributeError, TypeError, ElementTree.ParseError) as error:
        yield finding(CODE, "the URDF twin cannot be read", where=where, value=f"{error}"[:200])
        return
    if len(links) != len(subject.active_bodies):
        headline, bodies = "the URDF twin has another number of links", len(subject.active_bodies)
        yield finding(CODE, headline, where=where, value=bodies, bound=len(links), unit="bodies")
        return
    for body in subject.active_bodies:
        link = next(iter(links.values())) if len(links) == 1 else links.get(body.prim.GetName())
        if link is None:
            yield finding(CODE, "the URDF twin has no link of this body", where=at(body.prim))
        else:
            yield from _differences(subject, body, link)


def _differences(subject: Subject, body: Body, twin: TwinLink) -> Iterator[Diagnostic]:
    centre, inertia = mass_centre(body, subject), stated_inertia(body, subject)
    rows = (
        ("mass", "kg", body.mass_kg, twin.mass_kg, twin.mass_kg),
        ("mass centre", "m", centre, twin.centre_m, body.diagonal_m),
        ("inertia", "kg m2", inertia, twin.inertia_kgm2, float(np.abs(twin.inertia_kgm2).max())),
        ("number of colliders", "", len(body.active_colliders), twin.shapes, 1.0),
    )
    for quantity, unit, value, bound, scale in rows:
        if value is None:
            continue  # Reported by the mass and inertia rules.
        authored, stated = np.asarray(value, dtype=np.float64), np.asarray(bound, dtype=np.float64)
        if not float(np.abs(authored - stated).max()) <= STATED_TOLERANCE * scale:
            headline = f"the {quantity} is not that of the URDF twin"
            yield finding(
                CODE,
                headline,
                where=at(body.prim),
                value=format_numbers(authored),
                bound=format_numbers(stated),
                unit=unit,
            )


def _read(file: Path) -> dict[str, TwinLink]:
    """The links by name. Raises what malformed numbers raise."""
    return {link.get("name", ""): _link(link) for link in ElementTree.parse(file).getroot().findall("link")}


def _link(link: ElementTree.Element) -> TwinLink:
    inertial = link.find("inertial")
    origin, mass, entries = (None,) * 3 if inertial is None else map(inertial.find, ("origin", "mass", "inertia"))
    if mass is None or entries is None:
        raise ValueError("the link has no mass or inertia")
    xyz, rpy = (np.zeros(3) if origin is None else _floats(origin.get(key, "0 0 0")) for key in ("xyz", "rpy"))
    rows = [[float(entries.get(f"i{min(i, j)}{max(i, j)}", "nan")) for j in "xyz"] for i in "xyz"]
    R = Rotation.from_euler("xyz", rpy).as_matrix()  # URDF: fixed axes x, y, z
    return TwinLink(float(mass.get("value", "nan")), xyz, R @ np.array(rows) @ R.T, len(link.findall("collision")))


def _floats(text: str) -> FloatArray:
    numbers = np.array([float(word) for word in text.split()])
    if numbers.shape != (3,):
        raise ValueError(f"'{text[:60]}' is not three numbers")
    return numbers


RULE = Rule(CODE, "mass, mass centre, inertia to 0.1 %; number of colliders", "URDF `<inertial>`", check)
