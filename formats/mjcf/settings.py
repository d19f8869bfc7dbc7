"""Settings of an MJCF model that say how the rest is read: attributes of `<compiler>`.

mujoco.readthedocs.io/en/stable/XMLreference.html#compiler. Angles, Euler order, folders and the inference of limits
and inertias act on what is read. Others (balanceinertia, boundmass, fusestatic, ...) are kept for whoever simulates.
"""

from __future__ import annotations

from dataclasses import dataclass

from formats.attributes import choice, flag, numbers
from formats.mjcf.orientations import Orientations
from formats.xml_elements import Element, refuse


@dataclass(frozen=True)
class CompilerSettings:
    """`inertia_groups`: first and last group of geoms that count for inertia. `stated`: all attributes as written."""

    orientations: Orientations
    mesh_folder: str
    texture_folder: str
    strip_folders: bool
    infer_limits: bool
    inertia_from_geoms: str
    inertia_groups: tuple[float, float]
    stated: dict[str, str]


def compiler_settings(top: Element) -> CompilerSettings:
    """Of all `<compiler>` elements, a later one over an earlier one. Raises InvalidInput (`robot/invalid-value`)."""
    elements = top.named("compiler")
    a = {key: value for element in elements for key, value in element.attributes.items()}
    source = elements[-1].source if elements else top.source
    if a.get("coordinate", "local") != "local":
        refuse("robot/global-coordinates", "coordinate='global' is not read", source, value=a["coordinate"])
    sequence = a.get("eulerseq", "xyz")
    if len(sequence) != 3 or set(sequence.lower()) - set("xyz"):
        refuse("robot/invalid-value", f"eulerseq='{sequence}' should be three of x, y, z", source, value=sequence)
    asset_folder = a.get("assetdir", "")
    first, last = numbers(a, "inertiagrouprange", 2, (0.0, 5.0), source)
    return CompilerSettings(
        Orientations(choice(a, "angle", ("degree", "radian"), "degree", source) == "degree", sequence),
        a.get("meshdir", asset_folder),
        a.get("texturedir", asset_folder),
        flag(a, "strippath", False, source),
        flag(a, "autolimits", True, source),
        choice(a, "inertiafromgeom", ("true", "false", "auto"), "auto", source),
        (first, last),
        a,
    )


def asset_name(name: str, folder: str, strip: bool) -> str:
    """A file as the settings mean it: without its own folders where they are stripped, in `folder` unless absolute."""
    name = name.replace("\\", "/")
    if strip:
        name = name.rpartition("/")[2]
    absolute = name.startswith("/") or ":" in name[:2]
    return f"{folder.rstrip('/')}/{name}" if folder and name and not absolute else name
