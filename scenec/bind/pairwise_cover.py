"""Whole combinations that show every combination of every part: what stages, pictures and plans are made of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenec.bind.variants import Combination

AT_LEAST = 16  # where there are as many; some mixing of parts that are independent


def cover(parts: Sequence[Sequence[Combination]], least: int = AT_LEAST) -> tuple[Combination, ...]:
    """Combinations of all keys, as few as first fit finds, so that each of each part is in one; then others up
    to `least`, in rounds that pair them anew. Parts may share keys; the first has the first value of each."""
    rows: list[tuple[Combination, set[int]]] = []
    for number, combinations in enumerate(parts):
        for one in combinations:
            row, has = next((r for r in rows if number not in r[1] and _fits(r[0], one)), ({}, set[int]()))
            if not has:
                rows.append((row, has))
            row.update(one)
            has.add(number)
    found = [_completed(row, parts) for row, _ in rows]
    rng, most = np.random.default_rng(0), max(map(len, parts))
    for _ in range(least // most - len(found) // most):  # whole rounds, in which each combination comes up alike
        order = [rng.permutation(len(combinations)) for combinations in parts]
        for i in range(most):
            turned = [[of[k] for k in np.roll(ks, -i)] for of, ks in zip(parts, order, strict=True)]
            row = _completed({}, turned)
            found += [] if row in found else [row]
    return tuple(found)


def containing(chosen: Combination, parts: Sequence[Sequence[Combination]]) -> Combination:
    """A combination of all keys with the values chosen, else the first of each part that fits."""
    return _completed(dict(chosen), parts)


def _completed(row: Combination, parts: Sequence[Sequence[Combination]]) -> Combination:
    whole = dict(row)
    for combinations in parts:
        whole |= next(one for one in combinations if _fits(whole, one))
    return whole


def _fits(row: Combination, one: Combination) -> bool:
    return all(row.get(key, value) == value for key, value in one.items())
