"""Runs the finder on a measurement folder, as `mana gap find` does; a path goes in, `report.json` comes out.

No truth, case name or module of the generator is within reach of this file (an import contract holds it).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from schemas.diagnostics import InvalidInput
from sim.effects.candidacy import never
from sim.effects.effect import Effect
from simgap.kinds.free_body import candidates as free_body_candidates
from simgap.kinds.mechanism import candidates as mechanism_candidates
from simgap.run import find

ENGINE = "sim.bullet.replay_engine:BulletReplayEngine"
_TABLES = (mechanism_candidates, free_body_candidates)


def find_in(folder: Path, out: Path, left_out: Sequence[str] = ()) -> dict[str, Any]:
    """The report of a measurement folder, without the effects left out; a refused folder gives its diagnostic."""
    try:
        with _library_without(left_out):
            find(folder, out, engine=ENGINE, quick=True)
    except InvalidInput as refused:
        return {"refused": f"{refused.diagnostic.code}: {refused.diagnostic.headline}"}
    return json.loads((out / "report.json").read_bytes())


@contextmanager
def _library_without(names: Sequence[str]) -> Iterator[None]:
    """Candidate tables in which the named effects can never be observed; their declared numbers stay believed."""
    before = [table.EFFECTS for table in _TABLES]
    try:
        for table in _TABLES:
            vars(table)["EFFECTS"] = tuple(_unobservable(e) if e.name in names else e for e in table.EFFECTS)
        yield
    finally:
        for table, effects in zip(_TABLES, before, strict=True):
            vars(table)["EFFECTS"] = effects


def _unobservable(effect: Effect) -> Effect:
    return replace(
        effect,
        mechanism=replace(effect.mechanism, observable=never),
        free_body=replace(effect.free_body, observable=never),
    )
