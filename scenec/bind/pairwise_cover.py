"""Covers the combinations of all components by few whole combinations, which become scenes, pictures and plans."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenec.bind.variants import Combination

AT_LEAST = 16  # where there are as many, so that independent components are combined in several ways


def cover(parts: Sequence[Sequence[Combination]], least: int = AT_LEAST) -> tuple[Combination, ...]:
    """Combinations of all keys, as few as first fit finds, that contain each combination of each part; then more, up to
    `least`, in rounds that pair them anew. Parts may share keys; the first row has the first value of each."""
    rows: list[tuple[Combination, set[int]]] = []
    for number, combinations in enumerate(parts):
        for one in combinations:
            row, has = next((r for r in rows if number not in r[1] and _fits(r[0], one)), ({}, set[int]()))
            if not has:
                rows.append((row, has))
            row.update(one)
            has.add(number)
    cover_rows = [_completed(row, parts) for row, _ in rows]
    rng, most = np.random.default_rng(0), max(map(len, parts))
    for _ in range(least // most - len(cover_rows) // most):  # whole rounds, in which each combination comes up alike
        order = [rng.permutation(len(combinations)) for combinations in parts]
        for i in range(most):
            turned = [[of[k] for k in np.roll(ks, -i)] for of, ks in zip(parts, order, strict=True)]
            row = _completed({}, turned)
            cover_rows += [] if row in cover_rows else [row]
    return tuple(cover_rows)


def containing(chosen: Combination, parts: Sequence[Sequence[Combination]]) -> Combination:
    """A combination of all keys that extends `chosen` by the first fitting combination of each part."""
    return _completed(dict(chosen), parts)


def _completed(row: Combination, parts: Sequence[Sequence[Combination]]) -> Combination:
    whole = dict(row)
    for combinations in parts:
        whole |= next(one for one in combinations if _fits(whole, one))
    return whole


def _fits(row: Combination, one: Combination) -> bool:
    return all(row.get(key, value) == value for key, value in one.items())
