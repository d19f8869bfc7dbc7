"""Deterministic defects of robot descriptions: limits, axes, units, dynamics, references, loops, chains of links."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

from lxml import etree


def with_robot_defects(rng: Random, data: bytes) -> bytes:
    """A URDF or MJCF file with one to three defects more; empty where it is no well-formed XML."""
    try:
        root = etree.fromstring(data, etree.XMLParser(resolve_entities=False, huge_tree=False))
    except (etree.XMLSyntaxError, ValueError):
        return b""
    for _ in range(rng.choice((1, 1, 3))):
        rng.choice(_ROBOT_DEFECTS)(rng, root)
    return etree.tostring(root)


def _with_attribute(root: Any, *names: str) -> list[tuple[Any, str]]:
    return [(e, n) for e in root.iter() if isinstance(e.tag, str) for n in names if n in e.attrib]


def _odd_limit(rng: Random, root: Any) -> None:
    """Limits swapped, equal, not finite, or absent."""
    for element, name in _chosen(rng, _with_attribute(root, "lower", "range")):
        if name == "range":
            element.set(name, rng.choice(("1 -1", "0 0", "nan 1", "0 inf", "-90 90", "1")))
        else:
            lower, upper = element.get("lower"), element.get("upper", "0")
            pairs = ((upper, lower), ("0", "0"), ("nan", upper), (lower, "inf"), ("-1e9", "1e9"))
            element.attrib.update(dict(zip(("lower", "upper"), rng.choice(pairs), strict=True)))


def _odd_axis(rng: Random, root: Any) -> None:
    places = [(e, n) for e, n in _with_attribute(root, "xyz", "axis") if n == "axis" or e.tag == "axis"]
    for element, name in _chosen(rng, places):
        element.set(name, rng.choice(("0 0 0", "0 0 1000", "1e-30 0 0", "nan 0 1", "1 1", "0 0 -1")))


def _odd_unit(rng: Random, root: Any) -> None:
    """All masses, tensors, places or sizes times a power of ten: grams, millimetres, kg mm2."""
    names = rng.choice((("ixx", "iyy", "izz", "ixy", "ixz", "iyz", "diaginertia"), ("mass", "value"), ("xyz", "pos")))
    factor = rng.choice((1e3, 1e6, 1e-3, 1e-6, -1.0, 0.0))
    for element, name in _with_attribute(root, *names):
        try:
            numbers = [float(word) * factor for word in element.get(name).split()]
        except ValueError:
            continue
        element.set(name, " ".join(f"{number:.9g}" for number in numbers))


def _odd_link(rng: Random, root: Any) -> None:
    """A joint leads to another link: an absent one, its own parent, or one that is carried already."""
    ends = [(e, n) for e, n in _with_attribute(root, "link") if e.tag in ("parent", "child")]
    names = [e.get(n) for e, n in ends] or [""]
    for element, name in _chosen(rng, ends):
        element.set(name, rng.choice((*names, "nothing", "")))


def _odd_mesh(rng: Random, root: Any) -> None:
    values = ("../../../etc/hostname", "/etc/hostname", "absent.obj", "package://x/y.stl", "file:///etc/hostname", "")
    for element, name in _chosen(rng, _with_attribute(root, "filename", "file", "mesh", "scale")):
        element.set(
            name, rng.choice(("0 0 0", "-1 1 1", "nan 1 1", "1e9 1 1")) if name == "scale" else rng.choice(values)
        )


def _odd_dynamics(rng: Random, root: Any) -> None:
    names = ("damping", "friction", "stiffness", "armature", "effort", "velocity", "springref", "ref", "frictionloss")
    for element, name in _chosen(rng, _with_attribute(root, *names)):
        element.set(name, rng.choice(("nan", "inf", "-1", "0", "1e12", "1e-12", "x")))


def _many_links(rng: Random, root: Any) -> None:
    """A chain of links or bodies, up to 10,000."""
    count = rng.choice((3, 40, 300, 10_000))
    if root.tag == "mujoco":
        worlds = root.findall("worldbody")
        for k in range(count if worlds else 0):
            body = etree.SubElement(worlds[0], "body", name=f"chain_{k}", pos="0 0 1")
            etree.SubElement(body, "joint", name=f"chain_joint_{k}", type="hinge")
            etree.SubElement(body, "geom", size="0.1")
        return
    parent = next((e.get("name", "") for e in root.findall("link")), "")
    for k in range(count):
        link = etree.SubElement(root, "link", name=f"chain_{k}")
        geometry = etree.SubElement(etree.SubElement(link, "collision"), "geometry")
        etree.SubElement(geometry, "box", size="0.1 0.1 0.1")
        joint = etree.SubElement(root, "joint", name=f"chain_joint_{k}", type="continuous")
        etree.SubElement(joint, "parent", link=parent)
        etree.SubElement(joint, "child", link=f"chain_{k}")
        parent = f"chain_{k}"


def _chosen(rng: Random, places: list[tuple[Any, str]]) -> list[tuple[Any, str]]:
    return rng.sample(places, min(len(places), rng.choice((1, 1, 3, 100))))


_ROBOT_DEFECTS: tuple[Callable[[Random, Any], None], ...] = (
    *(_odd_limit, _odd_limit, _odd_axis, _odd_unit, _odd_unit, _odd_link, _odd_mesh, _odd_dynamics, _many_links),
)
