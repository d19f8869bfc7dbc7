"""The list of mechanism cases: family, scene, cause, level and log by a rule from a number, none by hand."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.suites.gap2.generate.causes.cause import Cause, Where
from tests.suites.gap2.generate.causes.combinations import PAIRS, TWINS
from tests.suites.gap2.generate.causes.library import LIBRARY, library_cause
from tests.suites.gap2.generate.causes.outside import OUTSIDE
from tests.suites.gap2.generate.logs import csv_bytes, declared, digest_of, draw_style, written
from tests.suites.gap2.generate.parameters import Number
from tests.suites.gap2.generate.plant import Hidden, Plant, Trial, observe
from tests.suites.gap2.generate.power import LEVELS, Readings, miss, strength_for
from tests.suites.gap2.generate.rivals import rivals_of
from tests.suites.gap2.generate.scenes import SCENES, Recording, draw_plant, draw_recording, sizes_of
from tests.suites.gap2.generate.truth import SAME, Family, HiddenEffect, Truth

SEED = 290629
# Of twenty numbers in a row: six controls, four outside causes, two left out, three twins, four singles, one pair.
ROUND: tuple[Family, ...] = (
    *("control", "single", "outside", "twin", "control", "left_out", "single", "outside", "control", "two"),
    *("control", "outside", "twin", "single", "control", "outside", "left_out", "single", "twin", "control"),
)
CONTROLS = ("none", "nuisance", "noise", "engine", "nuisance")
_STRIDES = (7, 11, 13, 17)
_ATTEMPTS = 8  # mechanisms drawn until the level can be reached
_VISIBLE, _ATTEMPTS_LABELLED = 2.0 * SAME, 3  # noncentrality beyond what believed numbers' tolerance explains; draws
_LARGEST_SIGMA = 0.02  # rad, or of a slide's length: no sensor is noisier
_OFF = 0.03  # believed numbers may be off by that share
_ENGINE_MISS = 0.5  # noise levels that another integrator may make
_NOISIER, _COLOUR = 5.0, 0.7
_LEAST_TRAVEL = 30.0  # noise levels


@dataclass(frozen=True)
class CaseFiles:
    """A case on disk before it is written: file contents by relative path, and the truth beside them."""

    files: dict[str, bytes]
    truth: Truth


@dataclass(frozen=True)
class _Draft:
    plant: Plant
    recording: Recording
    readings: Readings
    truth: Truth
    colour: float = 0.0


def family_of(number: int) -> Family:
    """The family of a case, without making it."""
    return ROUND[number % len(ROUND)]


def turn_of(number: int) -> int:
    """How many cases of its family come before a case."""
    family = family_of(number)
    return number // len(ROUND) * ROUND.count(family) + ROUND[: number % len(ROUND)].count(family)


def mechanism_case(number: int) -> CaseFiles:
    """The case of that number; the same number gives the same bytes."""
    family, turn = family_of(number), turn_of(number)
    draft = _control(number, turn) if family == "control" else _hiding(number, family, turn)
    return _files(draft, np.random.default_rng([SEED, number, 999]))


def write_case(case: CaseFiles, folder: Path) -> Path:
    """Writes the finder's files into `folder/<hash>`; returns that path. The truth is not among them."""
    root = folder / case.truth.measurement
    for name, data in case.files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return root


def _control(number: int, turn: int) -> _Draft:
    """Nothing hidden: as believed; numbers off by a few percent; a noisy coloured sensor; another integrator."""
    rng = np.random.default_rng([SEED, number])
    kind, scene = CONTROLS[turn % len(CONTROLS)], SCENES[turn * 5 % len(SCENES)]
    plant, recording = _moving(scene, rng)
    actual, hidden = plant, Hidden()
    if kind == "nuisance":
        actual = _slightly_off(plant, rng)
    if kind == "noise":
        recording = replace(recording, sigma=min(_NOISIER * recording.sigma, _coarsest(plant)))
    readings = observe(actual, hidden, recording.trials, recording.step_s)
    if kind == "engine":
        step = 1.0 / 240.0
        while True:
            readings = observe(actual, Hidden(step_s=step), recording.trials, recording.step_s)
            if _miss(plant, readings, recording) < _ENGINE_MISS or step < 1e-4:
                break
            step *= 0.5
    truth = _truth(number, "control", plant, recording, readings, control=kind)
    return _Draft(plant, recording, readings, truth, _COLOUR if kind == "noise" else 0.0)


def _hiding(number: int, family: Family, turn: int) -> _Draft:
    causes, scenes, level, twin = _chosen(family, turn)
    best: _Draft | None = None
    for attempt in range(_ATTEMPTS):
        rng = np.random.default_rng([SEED, number, attempt])
        scene = scenes[int(rng.integers(len(scenes)))]
        draft = _with_causes(number, family, scene, causes, level, twin, rng)
        if draft.truth.level_reached and family != "two":
            draft = _labelled(draft, causes[0])
            if draft.truth.visible > _VISIBLE or attempt == _ATTEMPTS_LABELLED:
                return draft
        elif draft.truth.level_reached:
            return draft
        if best is None or draft.truth.miss > best.truth.miss:
            best = draft
    assert best is not None
    return best if family == "two" or best.truth.visible else _labelled(best, causes[0])


def _chosen(family: Family, turn: int) -> tuple[list[Cause], Sequence[str], str, str]:
    """(causes, scenes, level, twin) of a turn within a family."""
    if family == "two":
        first, second, scene = PAIRS[turn % len(PAIRS)]
        return [library_cause(first), library_cause(second)], (scene,), ("gross", "large")[turn // len(PAIRS) % 2], ""
    if family == "twin":
        first, second, scenes = TWINS[turn * 7 % len(TWINS)]
        cause = [c for c in LIBRARY if c.name == first][-1]  # of the gains the one on the rate, which friction mimics
        return [cause], scenes, ("gross", "large")[turn % 2], second
    if family == "outside":
        cause = OUTSIDE[turn % len(OUTSIDE)]
        return [cause], cause.scenes, ("gross", "gross", "large")[(turn + turn // len(OUTSIDE)) % 3], ""
    stride = next(s for s in _STRIDES if len(LIBRARY) % s)
    cause = LIBRARY[(turn * stride + (5 if family == "left_out" else 0)) % len(LIBRARY)]
    levels = ("gross", "large", "gross", "large", "medium") if family == "single" else ("gross", "large")
    return [cause], cause.scenes, levels[(turn + turn // len(LIBRARY)) % len(levels)], ""


def _with_causes(
    number: int, family: Family, scene: str, causes: Sequence[Cause], level: str, twin: str, rng: np.random.Generator
) -> _Draft:
    rubs = any(c.rubs for c in causes) or twin in ("joint.friction_asymmetry", "sensor.scale")
    bare = twin in ("joint.armature", "joint.gravity_load") and scene == "pendulum"  # friction would tell them apart
    plant, recording = _moving(scene, rng, rubs=rubs, bare=bare, supply=any(c.supply for c in causes))
    joint = int(rng.integers(plant.joints))
    where = Where(plant, joint, sizes_of(plant, recording, joint), rng.random(4))
    hidden, effects, reached = Hidden(joint), [], True
    for cause in causes:
        strength, recording, is_reached = _sized(cause, where, recording, level)
        reached = reached and is_reached
        one = cause.hidden(strength, where)
        hidden = hidden.beside(one)
        effects.append(HiddenEffect(cause.name, "" if cause.whole else str(joint), dict(cause.checked(one)), strength))
    readings = observe(plant, hidden, recording.trials, recording.step_s)
    truth = _truth(
        number,
        family,
        plant,
        recording,
        readings,
        effects=tuple(effects),
        level=level,
        level_reached=reached,
        twin=twin,
        left_out=(causes[0].name,) if family == "left_out" else (),
    )
    return _Draft(plant, recording, readings, replace(truth, log={"joint": joint, "draws": where.draws.tolist()}))


def _moving(
    scene: str, rng: np.random.Generator, *, rubs: bool = False, bare: bool = False, supply: bool = False
) -> tuple[Plant, Recording]:
    """A mechanism and its recording in which every joint moves by many noise levels."""
    while True:
        plant, period = draw_plant(scene, rng, rubs=rubs, bare=bare)
        recording = draw_recording(plant, period, rng, supply=supply)
        sizes = [sizes_of(plant, recording, joint) for joint in range(plant.joints)]
        if all(s.speed > 0.0 and s.reach > _LEAST_TRAVEL * recording.sigma for s in sizes):
            return plant, recording


def _sized(cause: Cause, where: Where, recording: Recording, level: str) -> tuple[float, Recording, bool]:
    """(strength, recording, level reached); a cause that is too large at its least gets a noisier sensor."""

    def miss_at(strength: float) -> float:
        hidden = cause.hidden(strength, where)
        return _miss(where.plant, observe(where.plant, hidden, recording.trials, recording.step_s), recording)

    smallest, target = miss_at(cause.least), LEVELS[level]
    if smallest > target:
        sigma = min(recording.sigma * smallest / target, _coarsest(where.plant))
        return cause.least, replace(recording, sigma=sigma), smallest * recording.sigma / sigma < 1.1 * target
    strength, reached = strength_for(miss_at, target, cause.least, cause.most)
    return strength, recording, reached


def _labelled(draft: _Draft, cause: Cause) -> _Draft:
    """The case with what else explains it."""
    joint, draws = int(draft.truth.log["joint"]), np.array(draft.truth.log["draws"])
    where = Where(draft.plant, joint, sizes_of(draft.plant, draft.recording, joint), draws)
    strength = draft.truth.effects[0].strength

    def readings_at(share: float, trials: Sequence[Trial]) -> Readings:
        return observe(draft.plant, cause.hidden(share * strength, where), trials, draft.recording.step_s)

    visible, rivals = rivals_of((cause.name,), where, draft.recording, readings_at)
    truth = draft.truth.with_rivals(visible, {r.name: r.noncentrality for r in rivals})
    return replace(draft, truth=truth)


def _truth(
    number: int, family: Family, plant: Plant, recording: Recording, readings: Readings, **more: object
) -> Truth:
    return replace(
        Truth(number, "", family, "mechanism", plant.scene),
        miss=_miss(plant, readings, recording),
        miss_whole=miss(plant, readings, recording.trials, recording.sigma, float("inf"), recording.step_s),
        horizon_s=recording.horizon_s,
        sigma=recording.sigma,
        **more,
    )


def _miss(plant: Plant, readings: Readings, recording: Recording) -> float:
    return miss(plant, readings, recording.trials, recording.sigma, recording.horizon_s, recording.step_s)


def _coarsest(plant: Plant) -> float:
    return _LARGEST_SIGMA * (float(plant.mass[0] / 20.0) ** 0.5 if plant.slides else 1.0)


def _slightly_off(plant: Plant, rng: np.random.Generator) -> Plant:
    """Inertia, friction, damping, weight and gains up to 3 % from what is believed."""

    def off() -> np.ndarray:
        return 1.0 + rng.uniform(-_OFF, _OFF, plant.joints)

    numbers = plant.numbers.copy()
    for which in (Number.COULOMB, Number.VISCOUS, Number.GRAVITY_FACTOR, Number.GAIN, Number.KP, Number.KD):
        numbers[:, which] *= off()
    return replace(plant, inertia=plant.inertia * off(), numbers=numbers)


def _files(draft: _Draft, rng: np.random.Generator) -> CaseFiles:
    plant, recording = draft.plant, draft.recording
    style = draw_style(plant, recording, rng, colour=draft.colour)
    tables, sigma = written(plant, recording, draft.readings, style, rng)
    files = {f"trajectories/{name}.csv": csv_bytes(table, list(table)) for name, table in tables.items()}
    measurement = digest_of(files)
    spec = declared(plant, recording, style, tables, sigma, measurement, rng)
    files["measurement.yaml"] = (json.dumps(spec, indent=1) + "\n").encode()  # JSON is YAML
    effects = tuple(replace(e, joint=style.joints[int(e.joint)] if e.joint else "") for e in draft.truth.effects)
    log = {
        "rate_hz": recording.rate_hz,
        "trials": len(recording.trials),
        "rows": sum(len(t["t"]) for t in tables.values()),
        "resampled_hz": style.resampled_hz,
        "cutoff_hz": style.cutoff_hz,
        "corrupted": len(style.corrupted),
        "quantised": style.count,
        "noise_left": sigma,
    }
    truth = replace(draft.truth, measurement=measurement, effects=effects, log=log)
    return CaseFiles(files, truth)
