"""What the gate of `mana assets validate` says of a package with one number spoiled: a section of the demo page."""

from __future__ import annotations

import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from assetkit.library.judge_file import validate_file
from schemas.diagnostics import Diagnostic, Severity

MAIN, PHYSICS = "usd/{name}.usda", "usd/payloads/{name}_physics.usda"
# What is done, the layer it is done to, the attribute, and its new value.
SPOILS = (
    ("the mass is a thousandth", MAIN, "physics:mass", lambda text: repr(float(text) / 1000.0)),
    (
        "one moment of inertia is ten times the others",
        MAIN,
        "physics:diagonalInertia",
        lambda text: _first_tenfold(text),
    ),
    ("the mass centre lies outside", MAIN, "physics:centerOfMass", lambda text: "(0, 0, 100)"),
    ("dynamic friction above static", PHYSICS, "physics:dynamicFriction", lambda text: "0.9"),
    ("restitution above one", PHYSICS, "physics:restitution", lambda text: "1.4"),
    ("one collider is switched off", PHYSICS, "physics:collisionEnabled", lambda text: "0"),
)


@dataclass(frozen=True)
class Spoiled:
    """One defect put into a clean package; `gate` and `outside` hold what is said of it and not of the clean one."""

    what: str
    gate: tuple[Diagnostic, ...]
    outside: tuple[Diagnostic, ...]


def spoil_package(package: Path) -> tuple[Spoiled, ...]:
    """Each of `SPOILS` in a copy of the released `package`, and what the gate and the outside validators say then."""
    clean = {_words(d) for d in validate_file(package / MAIN.format(name=package.name))}
    spoiled = []
    with tempfile.TemporaryDirectory(prefix="mana") as folder:
        for number, (what, layer, attribute, change) in enumerate(SPOILS):
            copy = Path(folder) / str(number) / package.name
            shutil.copytree(package, copy)
            file = copy / layer.format(name=package.name)
            pattern = re.compile(rf"( {attribute} = )(.*)")
            text, count = pattern.subn(lambda m, change=change: m[1] + change(m[2]), file.read_text(), count=1)
            if count == 0:
                continue
            file.write_text(text)
            said = [
                d
                for d in validate_file(copy / MAIN.format(name=package.name))
                if d.severity is not Severity.INFO and _words(d) not in clean
            ]
            outside = tuple(d for d in said if d.code in ("asset/simready-rule", "asset/usd-rule"))
            spoiled.append(Spoiled(what, tuple(d for d in said if d not in outside), outside))
    return tuple(spoiled)


def _words(diagnostic: Diagnostic) -> tuple[str, str, str | None]:
    return diagnostic.code, diagnostic.headline, diagnostic.where.prim


def _first_tenfold(text: str) -> str:
    moments = [float(word) for word in text.strip("()").split(",")]
    return f"({10.0 * max(moments)}, {moments[1]}, {moments[2]})"
