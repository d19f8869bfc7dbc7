"""Judge samples by their poses alone, with geometry code that the sampler does not share (`scene_check`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from runtime_plan.plan import Plan
from runtime_plan.samples import Samples
from scene_check.batch import BatchPoses, SceneRules
from scene_check.check_batch import check_batch
from scene_check.from_plan import scene_rules
from scene_check.model import TOLERANCE_M
from schemas.scene.runtime_plan import PlanCombination, PlanThing, RuntimePlan

Row = dict[str, Any]  # index, kind, things, value, bound, unit, label


class Judge:
    """Verdicts on samples of one plan; the rules of each combination are derived once."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan.document
        self._names = plan.tables.names

        @cache
        def rules(index: int) -> SceneRules:
            return scene_rules(plan.document, plan.document.combinations[index])

        self._rules = rules

    def violations(self, samples: Samples, indices: tuple[int, ...] | None = None) -> Iterator[Row]:
        """Every violation of every sample, in order; `indices` of samples that do not follow one another."""
        numbered_rows = list(self._too_high(samples))
        raised = samples.rise_m[:, None, None] * np.array([0.0, 0.0, 1.0])
        samples = replace(samples, position_m=samples.position_m - raised)  # judged where the background is lowest
        for index in np.unique(samples.combination).tolist():
            rows = np.flatnonzero(samples.combination == index)
            numbered_rows += self._of_combination(index, samples, rows)
        for k, row in sorted(numbered_rows, key=lambda item: item[0]):
            yield {"index": indices[k] if indices else samples.start + k, **row}

    def _too_high(self, samples: Samples) -> Iterator[tuple[int, Row]]:
        """Samples whose background is not within its range of heights."""
        most = np.array([combination.rise_m for combination in self._plan.combinations])[samples.combination]
        for k in np.flatnonzero(~((samples.rise_m >= 0.0) & (samples.rise_m <= most + TOLERANCE_M))).tolist():
            value, bound = float(samples.rise_m[k]), float(most[k])
            yield k, {"kind": "height", "things": [], "value": value, "bound": bound, "unit": "m", "label": ""}

    def _of_combination(self, index: int, samples: Samples, rows: np.ndarray) -> Iterator[tuple[int, Row]]:
        combination, rules = self._plan.combinations[index], self._rules(index)
        columns = [self._names.index(thing.id) for thing in combination.objects]
        is_complete = np.ones(len(rows), dtype=bool)
        for k, text, names in _incomplete(combination, self._names, samples, rows, columns):
            is_complete[np.searchsorted(rows, k)] = False
            yield k, {"kind": text, "things": names, "value": 0.0, "bound": 0.0, "unit": "", "label": ""}
        complete_rows = rows[is_complete]
        if not combination.distractors:
            yield from self._judged(combination.objects, rules, samples, complete_rows)
            return
        present = samples.present[complete_rows][:, columns]
        patterns, pattern_of = np.unique(present, axis=0, return_inverse=True)
        for k, pattern in enumerate(patterns):
            there = [thing for thing, is_there in zip(combination.objects, pattern, strict=True) if is_there]
            some = {thing.id for thing in there}
            yield from self._judged(
                there,
                replace(rules, things=tuple(thing for thing in rules.things if thing.name in some)),
                samples,
                complete_rows[pattern_of.reshape(-1) == k],
            )

    def _judged(
        self, things: Sequence[PlanThing], rules: SceneRules, samples: Samples, complete_rows: np.ndarray
    ) -> Iterator[tuple[int, Row]]:
        """Violations of `complete_rows`, in all of which these things are present."""
        columns = [self._names.index(thing.id) for thing in things]
        poses = batch_poses(self._plan, things, rules, samples, complete_rows, columns)
        for number, violations in check_batch(rules, poses):
            for violation in violations:
                yield (
                    int(complete_rows[number]),
                    {
                        "kind": violation.kind,
                        "things": list(violation.names),
                        "value": float(violation.value),
                        "bound": float(violation.bound),
                        "unit": violation.unit,
                        "label": violation.label,
                    },
                )


def _incomplete(
    combination: PlanCombination, names: tuple[str, ...], samples: Samples, rows: np.ndarray, columns: list[int]
) -> Iterator[tuple[int, str, list[str]]]:
    """Samples without a thing of their combination, with another one, or with another owner than the plan's."""
    expected = np.isin(np.arange(len(names)), columns)
    present, wrong = samples.present[rows], samples.present[rows] != expected
    for entry in combination.distractors:
        optional = [names.index(name) for name in entry.things]
        count = present[:, optional].sum(axis=1)
        for k in np.flatnonzero((count < entry.least) | (count > entry.most)).tolist():
            yield int(rows[k]), "count", list(entry.things)
        wrong[:, optional] = False
    for k, column in np.argwhere(wrong).tolist():
        yield int(rows[k]), "extra" if present[k, column] else "missing", [names[column]]
    for thing, column in zip(combination.objects, columns, strict=True):
        parent, _ = combination.standing_on(thing)
        owner = names.index(parent) if parent in names else -1
        wrong = present[:, column] & (samples.support[rows, column] != owner)
        for k in np.flatnonzero(wrong).tolist():
            yield int(rows[k]), "support", [thing.id]


def batch_poses(
    plan: RuntimePlan,
    things: Sequence[PlanThing],
    rules: SceneRules,
    samples: Samples,
    rows: np.ndarray,
    columns: list[int],
) -> BatchPoses:
    """Poses for `scene_check`: the stance nearest to each quaternion, up to a rotation about z, and the yaw (rad)."""
    shape = (len(rows), len(columns))
    body_stance, known = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=bool)
    yaw = np.zeros(shape)
    for i, (thing, column) in enumerate(zip(things, columns, strict=True)):
        body = np.repeat(thing.bodies, [len(plan.bodies[b].stances) for b in thing.bodies])
        stances = np.concatenate([np.arange(len(plan.bodies[b].stances)) for b in thing.bodies])
        quats = np.array([stance.quat_wxyz for b in thing.bodies for stance in plan.bodies[b].stances])
        w, x, y, z = np.moveaxis(_times_conjugate(samples.quat_wxyz[rows, column], quats), -1, 0)
        tilt = 2.0 * np.hypot(x, y) / np.sqrt(w * w + x * x + y * y + z * z)
        allowed = [spot.stance for spot in thing.spots] or thing.stances
        cost = np.where(tilt <= TOLERANCE_M, ~np.isin(stances, allowed), 2.0 + tilt)
        cost = np.where(samples.asset_index[rows, column, None] == body, cost, np.inf)
        pick = cost.argmin(axis=1)
        row = np.arange(len(rows))
        body_stance[:, i], known[:, i] = pick, cost[row, pick] < 2.0
        yaw[:, i] = 2.0 * np.arctan2(z[row, pick], w[row, pick])
    origins = samples.position_m[rows][:, columns]
    return BatchPoses(origins, yaw, body_stance, known & np.isfinite(origins).all(axis=-1))


def _times_conjugate(quats: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(n, m, 4) products of quaternions (n, 4) with the conjugates of (m, 4), wxyz."""
    a, b, c, d = (part[:, None] for part in quats.T)
    w, x, y, z = (part[None, :] for part in (others * np.array([1.0, -1.0, -1.0, -1.0])).T)
    return np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )
