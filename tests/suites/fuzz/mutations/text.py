"""Damage to tokens of text files: numbers, indices, lines, brackets, names of files, nesting, encodings."""

from __future__ import annotations

import re
from random import Random

from tests.suites.fuzz.mutations.raw_bytes import Mutation, flip_bits, odd_words

OUTSIDE = b"/@outside@"  # stands for the absolute path of the folder that no case may read; `cases` puts it in
ESCAPES = (
    *(b"../outside/secret", b"../../outside/secret", b"../../../outside/secret", OUTSIDE + b"/secret"),
    *(b"..\\outside\\secret", b"%2e%2e/outside/secret", b"file://" + OUTSIDE + b"/secret", b"x/../../outside/secret"),
)
ODD_NAMES = (
    *(b"/etc/hostname", b"http://a.b/c", b"file://host/c", b"C:\\x", b"\\\\host\\x", b"\x1b[31mred", b"new\nline"),
    *(b"\xff\xfe", b"a" * 5000, b"../" * 40 + b"x", b".", b"/", b"", b"nul\x00", b"~/x", b"$HOME/x", b"package://x/y"),
)
SUFFIXES = (b"", b".obj", b".mtl", b".png", b".xml", b".urdf", b".usda", b".yaml", b".bin", b".csv", b".stl", b".hdf5")

_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_FILE_NAME = re.compile(rb"[\w./%-]+\.(?:obj|mtl|png|jpg|jpeg|bin|xml|urdf|stl|dae|usda|usdc|usd|yaml|csv|npz|tga)\b")
ODD_NUMBERS = tuple(
    b"nan inf -inf 0 -0 -1 1 2 1e308 -1e308 1e39 1e-320 1e5000 99999999999999999999 2147483648 4294967295 65536 "
    b"1.#IND 0x10 1,5 1e 1e+ . - 1_000 \xd9\xa3".split(b" ")
)
_ODD_TEXTS = (b"", b"\xff\xfe", b"\x00", "é漢字".encode(), b" " * 300, b"\\", b'"', b"<", b"&x;", *ODD_NAMES)
_NESTED = (b"[", b"{", b'{"a":', b"<a>", b"(", b"- ", b'def "a" {\n', b"<body>", b"<link>", b"[[", b"a: {")


def odd_numbers(rng: Random, data: bytes) -> bytes:
    """A few numbers become NaN, infinite, huge, tiny, or no numbers."""
    numbers = list(_NUMBER.finditer(data))
    if not numbers:
        return flip_bits(rng, data)
    out = data
    for match in sorted(rng.sample(numbers, min(len(numbers), rng.choice((1, 1, 2, 30)))), key=lambda m: -m.start()):
        out = out[: match.start()] + rng.choice(ODD_NUMBERS) + out[match.end() :]
    return out


def nudge_index(rng: Random, data: bytes) -> bytes:
    """One whole number becomes another of the file's size of numbers."""
    numbers = [m for m in _NUMBER.finditer(data) if b"." not in m[0]]
    if not numbers:
        return odd_words(rng, data)
    match = rng.choice(numbers)
    return (
        data[: match.start()] + b"%d" % rng.choice((-1, 0, 1, 3, 10**3, 10**6, 10**9, -(10**6))) + data[match.end() :]
    )


def edit_lines(rng: Random, data: bytes) -> bytes:
    """Lines deleted, doubled, swapped, cut, or with another word."""
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
    numbers = list(_NUMBER.finditer(data))
    if not numbers:
        return odd_words(rng, data)
    out = data
    for match in sorted(rng.sample(numbers, min(len(numbers), rng.choice((1, 3, 30)))), key=lambda m: -m.start()):
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


def drop_brackets(rng: Random, data: bytes) -> bytes:
    """A bracket, quote or sign goes, or comes twice."""
    places = [m.start() for m in re.finditer(rb"[\[\](){}<>\"',:=/]", data)]
    out = data
    for at in sorted(rng.sample(places, min(len(places), rng.choice((1, 1, 2, 8)))), reverse=True):
        out = out[:at] + out[at : at + 1] * rng.choice((0, 0, 2)) + out[at + 1 :]
    return out


def other_files(rng: Random, data: bytes) -> bytes:
    """The name of a file becomes one outside the folder, on another machine, of the file itself, or no name at all."""
    names = list(_FILE_NAME.finditer(data))
    if not names:
        return edit_lines(rng, data)
    out = data
    for match in sorted(rng.sample(names, min(len(names), rng.choice((1, 1, 5)))), key=lambda m: -m.start()):
        suffix = b"." + match[0].rsplit(b".", 1)[1]
        escape = rng.choice(ESCAPES) + rng.choice((suffix, suffix, *SUFFIXES))
        out = out[: match.start()] + rng.choice((escape, escape, rng.choice(ODD_NAMES))) + out[match.end() :]
    return out


def nest_deeply(rng: Random, data: bytes) -> bytes:
    """Thousands of opened brackets or elements at some place."""
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(_NESTED) * rng.choice((300, 5_000, 100_000)) + data[at:]


TEXT: tuple[Mutation, ...] = (
    *(odd_numbers, nudge_numbers, nudge_numbers, nudge_index, nudge_index, edit_lines, edit_lines, transcode),
    *(drop_brackets, other_files, other_files, nest_deeply),
)
