"""Damage to the trees of JSON documents, also inside a GLB, and of YAML documents."""

from __future__ import annotations

import io
import json
import math
import re
import struct
from collections.abc import Callable
from copy import deepcopy
from random import Random
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from tests.suites.fuzz.mutations.raw_bytes import flip_bits
from tests.suites.fuzz.mutations.text import ESCAPES, SUFFIXES

_ODD_VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2**31, 2**53, 10**30, -(10**30), 0.5, 1e308, -1e308, 1e-320),
    *(float("nan"), float("inf"), float("-inf"), "\x1b[31m", "new\nline"),
    *("", "x", "../../x", "/etc/hostname", "http://a.b/c", "data:,", "\x00", "\ud800", [], {}, [[]], [0], {"a": 0}),
)
_KEY = re.compile(rb'"[^"\\\\]{1,40}"\\s*:\\s*')
_MOST_HOLDERS = 100_000  # of a document that grew by its own copies


def edit_json(rng: Random, data: bytes) -> bytes:
    """One to three members of a JSON document, also inside a GLB, deleted, replaced, doubled or swapped."""
    text, put = _json_of(data)
    try:
        document = json.loads(text)
        changed = json.dumps(_edited(rng, document)).encode()
    except (ValueError, RecursionError):
        return flip_bits(rng, data)
    return put(changed)


def double_key(rng: Random, data: bytes) -> bytes:
    """A key of a JSON object comes twice, with another value."""
    text, put = _json_of(data)
    keys = list(_KEY.finditer(text))
    if not keys:
        return flip_bits(rng, data)
    match, other = rng.choice(keys), rng.choice(keys)
    value = rng.choice((b"null", b"-1", b"[]", b"{}", b'"x"', b"1e999"))
    return put(text[: match.start()] + other[0] + value + b"," + text[match.start() :])


def edit_yaml(rng: Random, data: bytes) -> bytes:
    """As `edit_json` for a YAML document, which keeps its values and loses its style."""
    if b"&" in data:  # `odd_yaml` was here: written out, its aliases fill the memory
        return flip_bits(rng, data)
    try:
        document = YAML(typ="safe", pure=True).load(data)
        out = io.BytesIO()
        YAML(typ="safe", pure=True).dump(json.loads(json.dumps(_edited(rng, document), default=str)), out)
    except (YAMLError, ValueError, RecursionError, TypeError, LookupError, AttributeError):  # odd directives as well
        return flip_bits(rng, data)
    return out.getvalue()


def odd_yaml(rng: Random, data: bytes) -> bytes:
    """Aliases that grow or hold themselves, includes that go in circles or out of the folder, tags, many documents."""
    grown = "x0: &x0 [1]\n" + "".join(f"x{i}: &x{i} [{', '.join([f'*x{i - 1}'] * 10)}]\n" for i in range(1, 12))
    texts = (
        *(grown, "a: &a [1, *a]\n", "include: program.yaml\n", "include: ../outside/secret.yaml\n", "---\n"),
        *("include: /@outside@/secret.yaml\n", "<<: *absent\n", "? [1]\n: 2\n", "!!python/object:os.system x\n"),
        *("a: !!binary |\n  x\n", "%YAML 9.9\n---\n", "a: 0o777\n", "a: 2001-99-99\n", "a: 1:2:3\n", "- 1\n"),
    )
    lines = data.split(b"\n")
    lines.insert(rng.choice((0, 0, rng.randrange(len(lines)))), rng.choice(texts).encode())
    return b"\n".join(lines)


def _edited(rng: Random, document: Any) -> Any:
    """`document` with one to three changes; it is changed itself."""
    for _ in range(rng.choice((1, 1, 3))):
        holders = [h for h in _holders(document) if h]
        if not holders or len(holders) > _MOST_HOLDERS:
            break
        holder = rng.choice(holders)
        key = rng.choice(list(holder) if isinstance(holder, dict) else range(len(holder)))
        _edit_member(rng, holder, key, rng.choice(holders))
    return document


def _edit_member(rng: Random, holder: Any, key: Any, other: Any) -> None:
    value = holder[key]
    match rng.randrange(9):
        case 0:
            del holder[key]
        case 1:
            holder[key] = rng.choice(_ODD_VALUES)
        case 2:
            holder[key] = deepcopy(rng.choice(list(other.values()) if isinstance(other, dict) else other))
        case 3 if isinstance(holder, list):
            holder.extend(holder[key : key + 1] * rng.choice((1, 30)))
        case 4 | 5 if isinstance(value, int | float) and math.isfinite(value):
            holder[key] = rng.choice((value + 1, value - 1, value * 1000, -value, value / 3, 5120 + rng.randrange(7)))
        case 6 if isinstance(value, str):
            holder[key] = (rng.choice(ESCAPES) + rng.choice(SUFFIXES)).decode()
        case 7:
            for _ in range(rng.choice((5, 300))):
                holder[key] = rng.choice(([holder[key]], {"a": holder[key]}))
        case _:
            holder[key] = [value] if not isinstance(value, list) else (value[0] if value else None)


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
    """All objects and lists in `value`, outermost first, however deep."""
    holders: list[Any] = []
    waiting = [value]
    while waiting:
        item = waiting.pop()
        if isinstance(item, dict | list):
            holders.append(item)
            waiting += item.values() if isinstance(item, dict) else item
    return holders
