"""Damage to XML trees: elements, attributes, entities, and the defects of robot descriptions."""

from __future__ import annotations

from itertools import pairwise
from random import Random

from lxml import etree

from tests.suites.fuzz.mutations.raw_bytes import flip_bits
from tests.suites.fuzz.mutations.robot_defects import with_robot_defects
from tests.suites.fuzz.mutations.text import ODD_NUMBERS

_LETTERS = "abcdefghi"
_BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {b} "{("&" + a + ";") * 10}">' for a, b in pairwise(_LETTERS)
)
_DOCTYPES = (
    _BOMB + "]>",
    '<!DOCTYPE r [<!ENTITY i SYSTEM "../outside/secret.xml">]>',
    '<!DOCTYPE r [<!ENTITY i SYSTEM "file:///@outside@/secret.xml">]>',
    '<!DOCTYPE r SYSTEM "../outside/secret.dtd">',
    '<!DOCTYPE r [<!ENTITY % p SYSTEM "../outside/secret.dtd"> %p;]>',
)


def edit_xml(rng: Random, data: bytes) -> bytes:
    """One to three elements deleted, doubled, moved, or with another text or attribute."""
    try:
        root = etree.fromstring(data, etree.XMLParser(resolve_entities=False, huge_tree=False))
    except (etree.XMLSyntaxError, ValueError):
        return flip_bits(rng, data)
    for _ in range(rng.choice((1, 1, 3))):
        elements = [e for e in root.iter() if isinstance(e.tag, str) and e is not root]
        if not elements:
            break
        element, other = rng.choice(elements), rng.choice(elements)
        parent = element.getparent()
        if parent is None:
            break
        match rng.randrange(6):
            case 0:
                parent.remove(element)
            case 1:
                parent.append(etree.fromstring(etree.tostring(element)))
            case 2 if element not in other.iterancestors() and element is not other:
                other.append(element)
            case 3 if element.attrib:
                key = rng.choice(list(element.attrib))
                values: list[str] = ["", "#", "#nothing", "-1", "nan", "99999999999", *map(str, other.attrib.values())]
                element.set(key, rng.choice(values))
            case 4 if element.attrib:
                del element.attrib[rng.choice(list(element.attrib))]
            case _:
                words = [*map(str, (element.text or "").split())] or [""]
                words[rng.randrange(len(words))] = str(rng.choice(ODD_NUMBERS), "latin-1")
                element.text = " ".join(words)
    return etree.tostring(root)


def edit_robot(rng: Random, data: bytes) -> bytes:
    """One to three defects of robot descriptions (`with_robot_defects`)."""
    return with_robot_defects(rng, data) or flip_bits(rng, data)


def declare_entities(rng: Random, data: bytes) -> bytes:
    """Entities that grow, or that name a file, before the root, and one of them used in it."""
    start = data.find(b"?>") + 2 if data.lstrip().startswith(b"<?xml") else 0
    body = data[start:].replace(b'="', b'="&i;', 1) if rng.random() < 0.5 else data[start:].replace(b">", b">&i;", 1)
    return data[:start] + rng.choice(_DOCTYPES).encode() + body


def include_itself(rng: Random, data: bytes) -> bytes:
    """An include of the file itself, of one outside, or of none."""
    names = ("model.xml", "part.xml", "part.urdf", "../outside/secret.xml", "absent.xml", "")
    element = rng.choice(('<include file="{}"/>', '<xi:include href="{}" xmlns:xi="http://www.w3.org/2001/XInclude"/>'))
    end = data.find(b">") + 1
    return data[:end] + element.format(rng.choice(names)).encode() + data[end:]
