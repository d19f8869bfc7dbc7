"""Damage to bytes of any kind: bits, words, length fields, blocks. Each function takes a generator and bytes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from random import Random

Mutation = Callable[[Random, bytes], bytes]

_ODD_WORDS = (0x7FC00000, 0x7F800000, 0xFF800000, 0xFFFFFFFF, 0x80000000, 0x7FFFFFFF, 0, 1, 0x7F7FFFFF, 0x00000001)
_HEADER_BYTES = 512  # where formats keep their counts and sizes
_LARGE_COUNT = 1 << 20  # a 32-bit word below it may be a count or a size


def flip_bits(rng: Random, data: bytes) -> bytes:
    """1 to 32 bits flipped."""
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
    """The beginning of the file."""
    return data[: rng.randrange(len(data))]


def cut(rng: Random, data: bytes) -> bytes:
    """A block of bytes is missing."""
    start, length = rng.randrange(len(data)), rng.choice((1, 3, 40, 1000))
    return data[:start] + data[start + length :]


def repeat(rng: Random, data: bytes) -> bytes:
    """A block of bytes comes several times."""
    start, length = rng.randrange(len(data)), rng.choice((1, 12, 400))
    return data[:start] + data[start : start + length] * rng.choice((2, 3, 50)) + data[start + length :]


def shuffle_blocks(rng: Random, data: bytes) -> bytes:
    """Blocks in another order."""
    size = max(len(data) // rng.choice((2, 4, 16)), 1)
    blocks = [data[i : i + size] for i in range(0, len(data), size)]
    rng.shuffle(blocks)
    return b"".join(blocks)


def zero_block(rng: Random, data: bytes) -> bytes:
    """A block of zeros."""
    start, length = rng.randrange(len(data)), rng.choice((4, 64, 4096))
    return data[:start] + bytes(min(length, len(data) - start)) + data[start + length :]


def swap_endianness(rng: Random, data: bytes) -> bytes:
    """Words from some place on in the other byte order."""
    start = rng.randrange(len(data)) & ~3
    words = memoryview(data)[start : start + (len(data) - start) // 4 * 4]
    return (
        data[:start]
        + b"".join(bytes(words[i : i + 4])[::-1] for i in range(0, len(words), 4))
        + data[start + len(words) :]
    )


def length_fields(rng: Random, data: bytes) -> bytes:
    """Words of the head that may be counts or sizes become huge, one more, one less, or zero."""
    out = bytearray(data)
    places = [
        (at, order)
        for at in range(min(len(out), _HEADER_BYTES) - 3)
        for order in "<>"
        if 0 < struct.unpack_from(order + "I", out, at)[0] < _LARGE_COUNT
    ]
    for at, order in rng.sample(places, min(len(places), rng.choice((1, 1, 3)))):
        (count,) = struct.unpack_from(order + "I", out, at)
        values = (0xFFFFFFFF, 0x7FFFFFFF, 0x40000000, count + 1, count - 1, 0, len(data), 2 * count)
        struct.pack_into(order + "I", out, at, rng.choice(values) & 0xFFFFFFFF)
    return bytes(out)


def splice(rng: Random, data: bytes) -> bytes:
    """A block of the file replaces another one, of another length."""
    start, end = sorted((rng.randrange(len(data) + 1), rng.randrange(len(data) + 1)))
    source = rng.randrange(len(data))
    return data[:start] + data[source : source + rng.choice((4, 64, 1000, 20000))] + data[end:]


def polyglot(rng: Random, data: bytes) -> bytes:
    """The beginning or the end of a file of another kind is added."""
    head = rng.choice((b"%PDF-1.4\n", b"PK\x03\x04", b"glTF\x02\0\0\0", b"#usda 1.0\n", b"solid x\n", b"<html>", b"\0"))
    return head + data if rng.random() < 0.7 else data + head


BINARY: tuple[Mutation, ...] = (
    *(flip_bits, odd_words, truncate, cut, repeat, shuffle_blocks, zero_block, swap_endianness),
    *(length_fields, splice, polyglot),
)
