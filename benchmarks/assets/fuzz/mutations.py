"""Deterministic damage to asset files: every function takes a generator and bytes and returns other bytes."""

from __future__ import annotations

import io
import json
import re
import struct
import warnings
import zipfile
from collections.abc import Callable
from copy import deepcopy
from random import Random
from typing import Any

from lxml import etree

from benchmarks.assets.fuzz.robot_defects import with_robot_defects
from schemas.files.zip_damage import ZIP_DAMAGE

Mutation = Callable[[Random, bytes], bytes]

_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_ODD_NUMBERS = (
    b"nan inf -inf 0 -0 -1 1 2 1e308 -1e308 1e39 1e-320 1e5000 99999999999999999999 2147483648 4294967295 65536 "
    b"1.#IND 0x10 1,5 1e 1e+ . - 1_000 \xd9\xa3"
).split(b" ")
_ODD_WORDS = (0x7FC00000, 0x7F800000, 0xFF800000, 0xFFFFFFFF, 0x80000000, 0x7FFFFFFF, 0, 1, 0x7F7FFFFF, 0x00000001)
_ODD_VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2**31, 2**53, 10**30, -(10**30), 0.5, 1e308, -1e308, 1e-320),
    *("", "x", "../../x", "/etc/hostname", "http://a.b/c", "data:,", "\x00", "\ud800", [], {}, [[]], [0], {"a": 0}),
)
_ODD_TEXTS = (
    b"",
    b"\xff\xfe",
    b"\x00",
    "é漢字".encode(),
    b" " * 300,
    b"\\",
    b'"',
    b"<",
    b"&x;",
    b"a" * 5000,
    b"../" * 40 + b"x",
)


def flip_bits(rng: Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 4, 32))):
        out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def odd_words(rng: Random, data: bytes) -> bytes:
    """Extreme 32-bit numbers at a few places."""
    out = bytearray(data)
    for _ in range(rng.choice((1, 3, 20))):
        at = rng.randrange(max(len(out) - 4, 1)) & ~(3 * rng.randrange(2))
        struct.pack_into(rng.choice("<>") + "I", out, at, rng.choice(_ODD_WORDS)) if at + 4 <= len(out) else None
    return bytes(out)


def truncate(rng: Random, data: bytes) -> bytes:
    return data[: rng.randrange(len(data))]


def cut(rng: Random, data: bytes) -> bytes:
    start, length = rng.randrange(len(data)), rng.choice((1, 3, 40, 1000))
    return data[:start] + data[start + length :]


def repeat(rng: Random, data: bytes) -> bytes:
    start, length = rng.randrange(len(data)), rng.choice((1, 12, 400))
    return data[:start] + data[start : start + length] * rng.choice((2, 3, 50)) + data[start + length :]


def shuffle_blocks(rng: Random, data: bytes) -> bytes:
    size = max(len(data) // rng.choice((2, 4, 16)), 1)
    blocks = [data[i : i + size] for i in range(0, len(data), size)]
    rng.shuffle(blocks)
    return b"".join(blocks)


def zero_block(rng: Random, data: bytes) -> bytes:
    start, length = rng.randrange(len(data)), rng.choice((4, 64, 4096))
    return data[:start] + bytes(min(length, len(data) - start)) + data[start + length :]


def swap_endianness(rng: Random, data: bytes) -> bytes:
    start = rng.randrange(len(data)) & ~3
    words = memoryview(data)[start : start + (len(data) - start) // 4 * 4]
    return (
        data[:start]
        + b"".join(bytes(words[i : i + 4])[::-1] for i in range(0, len(words), 4))
        + data[start + len(words) :]
    )


def odd_numbers(rng: Random, data: bytes) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return flip_bits(rng, data)
    out = data
    for match in sorted(rng.sample(found, min(len(found), rng.choice((1, 1, 2, 30)))), key=lambda m: -m.start()):
        out = out[: match.start()] + rng.choice(_ODD_NUMBERS) + out[match.end() :]
    return out


def nudge_index(rng: Random, data: bytes) -> bytes:
    """One whole number becomes another of the file's size of numbers."""
    found = [m for m in _NUMBER.finditer(data) if b"." not in m[0]]
    if not found:
        return odd_words(rng, data)
    match = rng.choice(found)
    return (
        data[: match.start()] + b"%d" % rng.choice((-1, 0, 1, 3, 10**3, 10**6, 10**9, -(10**6))) + data[match.end() :]
    )


def edit_lines(rng: Random, data: bytes) -> bytes:
    lines = data.split(b"\n")
    for _ in range(rng.choice((1, 1, 5))):
        i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
        match rng.randrange(7):
            case 0:
                del lines[i]
            case 1:
                lines.insert(j, lines[i])
            case 2:
                lines[i], lines[j] = lines[j], lines[i]
            case 3:
                lines[i] = lines[i][: rng.randrange(len(lines[i]) + 1)]
            case 4:
                lines[i] = lines[i].upper()
            case 5:
                words = lines[i].split(b" ")
                words[rng.randrange(len(words))] = rng.choice(_ODD_TEXTS)
                lines[i] = b" ".join(words)
            case _:
                lines.insert(i, rng.choice(_ODD_TEXTS))
        lines = lines or [b""]
    return b"\n".join(lines)


def nudge_numbers(rng: Random, data: bytes) -> bytes:
    """A few numbers become other ordinary numbers."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return odd_words(rng, data)
    out = data
    for match in sorted(rng.sample(found, min(len(found), rng.choice((1, 3, 30)))), key=lambda m: -m.start()):
        number = float(match[0]) * rng.choice((-1, 0, 0.5, 2, 1e3, 1e-3)) + rng.choice((0, 0, 1))
        text = b"%d" % int(number) if b"." not in match[0] and abs(number) < 1e9 else b"%.9g" % number
        out = out[: match.start()] + text + out[match.end() :]
    return out


def transcode(rng: Random, data: bytes) -> bytes:
    """Other line ends, byte-order marks and encodings."""
    match rng.randrange(6):
        case 0:
            return data.replace(b"\n", b"\r\n")
        case 1:
            return data.replace(b"\r\n", b"\n").replace(b"\n", b"\r")
        case 2:
            return b"\xef\xbb\xbf" + data
        case 3:
            return data.decode("latin-1").encode("utf-16")
        case 4:
            return data.replace(b" ", b"\t")
        case _:
            return data.replace(b" ", b"  ") + b"\x1a"


def edit_json(rng: Random, data: bytes) -> bytes:
    """One to three members of a JSON document, also inside a GLB, deleted, replaced, doubled or swapped."""
    text, put = _json_of(data)
    try:
        document = json.loads(text)
    except ValueError:
        return flip_bits(rng, data)
    for _ in range(rng.choice((1, 1, 3))):
        holders = [h for h in _holders(document) if h]
        if not holders:
            break
        holder = rng.choice(holders)
        key = rng.choice(list(holder) if isinstance(holder, dict) else range(len(holder)))
        value = holder[key]
        match rng.randrange(7):
            case 0:
                del holder[key]
            case 5 | 6 if isinstance(value, int | float):
                holder[key] = rng.choice(
                    (value + 1, value - 1, value * 1000, -value, value / 3, 5120 + rng.randrange(7))
                )
            case 1:
                holder[key] = rng.choice(_ODD_VALUES)
            case 2:
                other = rng.choice(holders)
                holder[key] = deepcopy(rng.choice(list(other.values()) if isinstance(other, dict) else other))
            case 3 if isinstance(holder, list):
                holder.extend(holder[key : key + 1] * rng.choice((1, 30)))
            case _:
                holder[key] = [value] if not isinstance(value, list) else (value[0] if value else None)
    return put(json.dumps(document).encode())


def _json_of(data: bytes) -> tuple[bytes, Callable[[bytes], bytes]]:
    if data[:4] != b"glTF" or len(data) < 20:
        return data, lambda text: text
    length = struct.unpack_from("<I", data, 12)[0]
    rest = data[20 + length :]

    def put(text: bytes) -> bytes:
        text += b" " * (-len(text) % 4)
        return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON") + text + rest

    return data[20 : 20 + length], put


def _holders(value: Any) -> list[Any]:
    below = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    holders = [value] if isinstance(value, dict | list) else []
    return holders + [h for child in below for h in _holders(child)]


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
                words[rng.randrange(len(words))] = str(rng.choice(_ODD_NUMBERS), "latin-1")
                element.text = " ".join(words)
    return etree.tostring(root)


def edit_robot(rng: Random, data: bytes) -> bytes:
    """One to three defects of robot descriptions (`with_robot_defects`)."""
    return with_robot_defects(rng, data) or flip_bits(rng, data)


def edit_package(rng: Random, data: bytes) -> bytes:
    """A USDZ whose entries are damaged, doubled, renamed or dropped; written again without compression."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            entries = [(e.filename, package.read(e)) for e in package.infolist()]
    except ZIP_DAMAGE:
        return flip_bits(rng, data)
    i = rng.randrange(len(entries))
    name, content = entries[i]
    match rng.randrange(5):
        case 0:
            del entries[i]
        case 1:
            entries.append(entries[i])
        case 2:
            entries[i] = (rng.choice(("x.usda", "a/b.png", "x" * 200, "é.usdc", name.upper())), content)
        case _ if content:
            entries[i] = (name, rng.choice(BINARY)(rng, content))
        case _:
            entries.reverse()
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as package, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # A name that occurs twice is what is wanted here.
        for name, content in entries:
            package.writestr(zipfile.ZipInfo(name), content)
    return out.getvalue()


BINARY: tuple[Mutation, ...] = (
    *(flip_bits, odd_words, truncate, cut, repeat, shuffle_blocks, zero_block, swap_endianness),
)
TEXT: tuple[Mutation, ...] = (
    odd_numbers,
    nudge_numbers,
    nudge_numbers,
    nudge_index,
    nudge_index,
    edit_lines,
    edit_lines,
    transcode,
)
BY_SUFFIX: dict[str, tuple[Mutation, ...]] = {
    ".obj": (*TEXT, *TEXT, *BINARY),
    ".mtl": (*TEXT, *BINARY),
    ".ply": (*TEXT, *BINARY),
    ".stl": (*TEXT, *BINARY, *BINARY),
    ".gltf": (*[edit_json] * 12, *TEXT, *BINARY),
    ".glb": (*[edit_json] * 12, *BINARY),
    ".dae": (*[edit_xml] * 10, *TEXT, *BINARY),
    ".urdf": (*[edit_xml] * 6, *[edit_robot] * 12, *TEXT, *BINARY),
    ".xml": (*[edit_xml] * 6, *[edit_robot] * 12, *TEXT, *BINARY),
    ".usda": (*TEXT, *TEXT, *TEXT, *BINARY),
    ".usdc": BINARY,
    ".usd": (*TEXT, *BINARY),
    ".usdz": (*[edit_package] * 6, *BINARY),
}


def mutate(rng: Random, data: bytes, suffix: str) -> tuple[bytes, str]:
    """`data` damaged once to three times by what fits its kind, and the names of what was done."""
    names: list[str] = []
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if not data:
            break
        mutation = rng.choice(BY_SUFFIX.get(suffix.lower(), BINARY))
        data = mutation(rng, data)
        names.append(mutation.__name__)
    return data, "+".join(names)
