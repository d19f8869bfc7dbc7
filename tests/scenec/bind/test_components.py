"""Verdicts by component equal those of solving every combination of the whole program."""

import re
from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from benchmarks.scenes.solve_speed import racks
from scenec.bind.asset_library import AssetLibrary
from scenec.bind.components import lower
from scenec.bind.pairwise_cover import containing, cover
from scenec.check.judge_scene import violations
from scenec.compile import Compiled, compile_program
from scenec.explain.report import verdict_of
from scenec.ir.problem import Solved
from scenec.solve import solve
from scenec.source.read import read_program
from tests.support.scene import library as scene_library

APART_M = 0.6
LEFT = "relations: [{left_of: [o0, o1], gap: 0.3}]"
KEEP_OUT = "keep_outs: [{id: lamp, surface: top, ranges: {x: [0.5, 0.8]}}]"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> AssetLibrary:
    folder = tmp_path_factory.mktemp("library")
    for name in ("small", "other", "third"):
        scene_library.cube(folder, name)
    scene_library.open_bin(folder, "bin")
    return AssetLibrary(folder)


def row_of(pools: list[str], half_m: float = 0.01, more: str = "", deep_m: float = 0.5) -> str:
    """Pools in a row on one long table, each within `half_m` of a place of its own."""
    start = -0.5 * APART_M * (len(pools) - 1)
    lines = [f"background: {{asset: {{type: box, size_m: [{APART_M * len(pools)}, {deep_m}, 0.04]}}}}"]
    lines += ["anchors: {top: {object: background, surface: auto}}", "objects:"]
    for k, pool in enumerate(pools):
        lines.append(f"  - {{id: o{k}, asset: {{type: pool, candidates: [{{id: c, assets: [{pool}]}}]}}}}")
    lines += ["layout:", "  nodes:"]
    for k in range(len(pools)):
        x = start + k * APART_M
        span = f"ranges: {{x: [{x - half_m}, {x + half_m}]}}"
        lines.append(f"    o{k}: {{object: o{k}, placement: {{type: surface, surface: top, {span}}}}}")
    return "\n".join([*lines, more]) + "\n"


def compiled(text: str, folder: Path, library: AssetLibrary) -> Compiled:
    (folder / "program.yaml").write_text(text)
    return compile_program(folder / "program.yaml", library=library)


def test_independent_things_have_verdicts_of_their_own(tmp_path: Path, library: AssetLibrary):
    """Six things of four candidates each are 4096 combinations, but 24 verdicts, and each candidate is in a scene."""
    compiled_program = compiled(row_of(["small, other, third, bin"] * 6), tmp_path, library)
    assert compiled_program.report.combinations == 4096
    assert [component.things for component in compiled_program.report.components] == [(f"o{k}",) for k in range(6)]
    assert [len(component.combinations) for component in compiled_program.report.components] == [4] * 6
    assert not any(component.union for component in compiled_program.report.components)
    assert not compiled_program.report.diagnostics
    shown = Counter((item.id, item.asset_id) for scene in compiled_program.scenes for item in scene.objects)
    assert shown == {(f"o{k}", asset): 4 for k, asset in product(range(6), ("small", "other", "third", "bin"))}
    assert [row.combination for row in compiled_program.report.matrix] == [
        scene.combination for scene in compiled_program.scenes
    ]
    for problem, result in zip(compiled_program.problems, compiled_program.results, strict=True):
        assert isinstance(result, Solved)
        assert not violations(problem, result.placements)


@pytest.mark.parametrize("seed", range(6))
def test_components_say_what_the_whole_program_says(seed: int, tmp_path: Path, library: AssetLibrary):
    rng = np.random.default_rng([10, seed])
    pools = [str(rng.choice(["small, bin", "bin, small", "small, other", "small"])) for _ in range(3)]
    more = str(rng.choice(["", LEFT, KEEP_OUT]))
    more += "\nvariants: {backgrounds: [{id: small, background: {asset: {type: box, size_m: [1.4, 0.2, 0.04]}}}]}"
    text = row_of(pools, float(rng.uniform(0.0, 0.1)), more, float(rng.uniform(0.1, 0.4)))
    (tmp_path / "program.yaml").write_text(text)
    read = read_program(tmp_path / "program.yaml")
    assert read.program is not None
    lowered = lower(read.program, library, read.spans)
    report = compile_program(tmp_path / "program.yaml", library=library, explain=False).report
    assert len(report.matrix) == report.combinations == lowered.count
    expected = [verdict_of(solve(lowered.binder.problem(row.combination))) for row in report.matrix]
    assert [row.verdict for row in report.matrix] == expected
    assert report.verdict == min(expected, key=["infeasible", "budget_exhausted", "compiled"].index)


def test_what_may_meet_or_is_related_under_any_variant_is_one_component(tmp_path: Path, library: AssetLibrary):
    for half_m, more, count in ((0.01, "", 2), (0.01, LEFT, 1), (0.3, "", 1)):
        report = compiled(row_of(["small, other"] * 2, half_m, more), tmp_path, library).report
        assert len(report.components) == count


def test_the_fault_of_one_component_is_told_of_it_alone(tmp_path: Path, library: AssetLibrary):
    """The bin is deeper than the table; things elsewhere do not matter."""
    found = compiled(row_of(["small, other", "small, bin", "other, third"], deep_m=0.07), tmp_path, library)
    assert found.report.verdict == "infeasible"
    assert [c.verdict for c in found.report.components] == ["compiled", "infeasible", "compiled"]
    assert found.chosen == {"objects.o1": "bin"}
    assert "(with objects.o1: bin)" in found.report.diagnostics[-1].headline
    assert found.report.suggestions[0].edit == "drop candidate bin of o1"
    assert sum(row.verdict == "infeasible" for row in found.report.matrix) == 4


def test_a_union_without_a_scene_proves_nothing_of_one_candidate(tmp_path: Path):
    """Nine strips stand side by side along x, or along y; nine crosses of both have no room."""
    for name, size_m in (("long", (0.2, 0.015, 0.02)), ("wide", (0.015, 0.2, 0.02)), ("huge", (0.3, 0.3, 0.02))):
        scene_library.block(tmp_path / "library", name, size_m)
    library = AssetLibrary(tmp_path / "library")
    text = row_of(["long, wide"] * 9).replace(f"[{9 * APART_M}, 0.5, 0.04]", "[0.25, 0.25, 0.04]")
    text = re.sub(r"ranges: .*}}}", "ranges: {yaw: [0, 0]}}}", text) + "clearance: 0.005\n"
    found = compiled(text, tmp_path, library)
    (component,) = found.report.components
    assert component.union == tuple(f"o{k}" for k in range(9))
    assert [row.verdict for row in component.combinations] == ["budget_exhausted", "compiled", "compiled"]
    assert [d.code for d in found.report.diagnostics] == ["scene/union-footprints", "scene/budget-exhausted"]
    assert not found.report.proof
    one_too_large = compiled(text.replace("[long, wide]", "[long, huge]", 1), tmp_path, library).report
    assert one_too_large.verdict == "infeasible"  # proved with that candidate alone
    assert "objects.o0: huge" in one_too_large.diagnostics[-1].headline


def test_a_cover_shows_each_combination_of_each_part_and_agrees_on_shared_keys():
    rng = np.random.default_rng(11)
    for _ in range(40):
        values = {key: [f"{key}{v}" for v in range(rng.integers(2, 5))] for key in "abcd"}
        parts = []
        for _ in range(rng.integers(1, 5)):
            keys = sorted(rng.choice(list("abcd"), size=rng.integers(1, 3), replace=False))
            parts.append([dict(zip(keys, row, strict=True)) for row in product(*(values[key] for key in keys))])
        rows = cover(parts)
        assert all(any(one.items() <= row.items() for row in rows) for part in parts for one in part)
        assert all(row.keys() == rows[0].keys() for row in rows)
        assert rows[0] == {key: values[key][0] for key in rows[0]}
        assert len({frozenset(row.items()) for row in rows}) == len(rows)
        chosen = parts[-1][-1]
        assert chosen.items() <= containing(chosen, parts).items()


def test_combinations_are_counted_without_listing_them(tmp_path: Path):
    """Twenty racks of four assignments each: 80 verdicts, and no loop over a million million combinations."""
    (tmp_path / "racks.yaml").write_text(racks(20))
    report = compile_program(tmp_path / "racks.yaml").report
    assert report.verdict == "compiled"
    assert report.combinations == 4**20
    assert [len(component.combinations) for component in report.components] == [4] * 20
