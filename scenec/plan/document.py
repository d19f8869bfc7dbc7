"""Builds a RuntimeSamplingPlan from problems and their solved scenes: pools of judged cases for each combination."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from scenec.check.judge_plan import judge
from scenec.ir.names import Names
from scenec.ir.problem import Body, Problem, Solved
from scenec.plan.pools import PoolKey, plan_pools
from scenec.solve.model import SolverModel, model_of, owner_first
from schemas.scene.geometry import ScenePlace, rounded_value
from schemas.scene.plan_geometry import (
    written_keep_clear,
    written_keep_out,
    written_place,
    written_reach,
    written_relation,
    written_stance,
    written_thing,
)
from schemas.scene.program import PairedMaterial, SceneProgram
from schemas.scene.runtime_plan import PlanBody, PlanCombination, PlanDistractors, PlanPool, PlanProvenance, RuntimePlan

_MARK = "\x01"  # occurs in no name


def runtime_plan(
    program: SceneProgram,
    problems: Sequence[Problem],
    results: Sequence[Solved],
    packages: Path | None = None,
    *,
    file: str = "",
    seed: int = 0,
    diversity: float = 1.0,
    reached_by: Mapping[str, Collection[str]] | None = None,
) -> RuntimePlan:
    """The plan of a compiled program; `diversity` trades its size for coverage (1: some hundred cases a pool).

    `reached_by` are the keys that affect a thing, by its name (all, when None): pools whose keys have equal values are
    made once.

    Every case is judged by the independent checker at extreme poses; RuntimeError when one is refused, a defect of
    ours. Deterministic in program, packages, seed and diversity.
    """
    bodies = PlanBodies(packages)
    pools_by_key: dict[PoolKey, tuple[PlanPool, ...]] = {}
    share = diversity / max(1.0, len(problems) ** 0.5)
    combinations = []
    for problem, result in zip(problems, results, strict=True):
        base = model_of(problem)
        pools = plan_pools(base, result, seed, share, pools_by_key, reached_by)
        combinations.append(_combination(program, base, pools, bodies))
    plan = RuntimePlan(
        scene=program.scene,
        clearance_m=program.clearance,
        bodies=tuple(bodies.plan_bodies),
        combinations=tuple(combinations),
        materials=_materials(program),
        lighting=program.variants.lighting,
        cameras=program.cameras,
        split={"train": program.split.train, "eval": program.split.eval}
        if program.split.train or program.split.eval
        else {},
        provenance=PlanProvenance(
            program=file,
            program_hash=hashlib.sha256(program.model_dump_json().encode()).hexdigest(),
            compiler=_version(),
            seed=seed,
            diversity=diversity,
        ),
    )
    judge(plan)
    return plan


def plan_text(plan: RuntimePlan) -> str:
    """The plan as JSON with one line for each case, so that two plans can be compared line by line."""
    tree = plan.model_dump(mode="json")
    lines: list[str] = []
    for combination in tree["combinations"]:
        for pool in combination["pools"]:
            for k, case in enumerate(pool["cases"]):
                pool["cases"][k] = f"{_MARK}{len(lines)}{_MARK}"
                lines.append(json.dumps(case, separators=(",", ":")))
    quoted = json.dumps(_MARK)[1:-1]
    parts = json.dumps(tree, indent=1).split(f'"{quoted}')
    whole = [parts[0]]
    for part in parts[1:]:
        number, rest = part.split(f'{quoted}"', 1)
        whole += [lines[int(number)], rest]
    return "".join(whole) + "\n"


def _combination(
    program: SceneProgram, base: SolverModel, pools: tuple[PlanPool, ...], bodies: PlanBodies
) -> PlanCombination:
    problem, names = base.problem, Names(program)
    places = _places(problem, base)
    number = {key: k for k, key in enumerate(places)}
    things = [base.things[name] for name in owner_first(base.things)]
    return PlanCombination(
        combination=problem.combination,
        background=None if problem.background is None else bodies.number(problem.background),
        X_WB=tuple(tuple(float(v) for v in row) for row in problem.X_WB),  # pyright: ignore[reportArgumentType]
        places=tuple((owner, written_place(place)) for (owner, _), place in places.items()),
        things=tuple(
            written_thing(
                thing.name,
                thing.domain,
                [bodies.number(body) for body in thing.body.candidates or (thing.body,)],
                thing.parent,
                number[thing.parent, thing.place.name],
                thing.tags,
                thing.is_frame,
            )
            for thing in things
        ),
        pools=pools,
        relations=tuple(map(written_relation, problem.relations)),
        keep_outs=tuple(written_keep_out(rule, number[rule.parent, rule.place.name]) for rule in problem.keep_outs),
        keep_clear=tuple(map(written_keep_clear, problem.keep_clear)),
        rise_m=rounded_value(max(problem.rise_m, 0.0)),
        stacks=problem.stacks,
        distractors=tuple(
            PlanDistractors(things=names.copies[entry.id], least=entry.count[0], most=entry.count[1])
            for entry in program.distractors
        ),
        reach=None if problem.reach is None else written_reach(problem.reach),
        materials=tuple(material.id for material in program.variants.materials),
        lighting=tuple(lighting.id for lighting in program.variants.lighting),
    )


def _materials(program: SceneProgram) -> tuple[PairedMaterial, ...]:
    # Materials with the things of the plan instead of the program's objects.
    names = Names(program)
    nodes = program.layout.nodes.items()
    things = {
        thing.id: tuple(copy for node, written in nodes if written.object == thing.id for copy in names.copies[node])
        for thing in program.objects
    }
    return tuple(
        material.model_copy(update={"objects": tuple(t for o in material.objects for t in things.get(o, (o,)))})
        for material in program.variants.materials
    )


class PlanBodies:
    """Numbers the bodies of a plan, each once."""

    def __init__(self, packages: Path | None) -> None:
        self.packages = packages
        self.plan_bodies: list[PlanBody] = []
        self._number: dict[PlanBody, int] = {}

    def number(self, body: Body) -> int:
        """The number of a body."""
        plan_body = PlanBody(
            asset_id=body.asset_id,
            package=body.package,
            package_hash=self._hash(body.package),
            scale=body.scale,
            mass_kg=body.mass_kg,
            primitive=body.inline,  # pyright: ignore[reportArgumentType]
            joints=tuple((joint, rounded_value(position)) for joint, position in body.joints),
            stances=tuple(written_stance(stance) for stance in body.resting_orientations),
        )
        if plan_body not in self._number:
            self._number[plan_body] = len(self.plan_bodies)
            self.plan_bodies.append(plan_body)
        return self._number[plan_body]

    def _hash(self, package: str | None) -> str | None:
        if package is None or self.packages is None:
            return None
        return hashlib.sha256((self.packages / package / "record.json").read_bytes()).hexdigest()


def _places(problem: Problem, model: SolverModel) -> dict[tuple[str, str], ScenePlace]:
    things = (model.things[name] for name in owner_first(model.things))
    used = {(thing.parent, thing.place.name): thing.place for thing in things}
    return used | {(k.parent, k.place.name): k.place for k in problem.keep_outs if (k.parent, k.place.name) not in used}


def _version() -> str:
    try:
        return version("mana-sim")
    except PackageNotFoundError:
        return "unknown"
