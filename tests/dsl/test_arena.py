"""Environments as Arena's graphs: valid by a schema of its documentation, and the same orders when read again."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest

from dsl.arena import NotExportable, composition_of, export_environment, import_task
from dsl.pipeline_file import read_pipeline
from schemas.task.orders import Orders
from tests.support.bad_inputs.pipeline import SOUND, write

SCHEMA = json.loads((Path(__file__).parents[1] / "data" / "arena_graph.schema.json").read_text())
STAGES = {
    "pick": "{id: pick, score: 2, success: {_func: held_by, object: '@pickable'}}",
    "place": "{id: place, score: 8, success: {_func: dwell, for_s: 0.5, of: "
    "{_func: on, object: '@pickable', support: can}}}",
}
ONE = "nodes: [{id: stand, score: 10, success: {_func: upright, object: '@pickable'}}]"
PACKAGES = SOUND.replace("{type: cylinder, radius_m: 0.04, height_m: 0.1}", "cup_a")
PACKAGES = PACKAGES.replace("{type: cylinder, radius_m: 0.03, height_m: 0.1}", "{type: fixed, id: can_a}")
PACKAGES = PACKAGES.replace("{asset: {type: box, size_m: [1.2, 0.8, 0.05]}}", "{asset: table_a}")


def orders(task: str, folder: Path) -> Orders:
    """A pipeline of packages with another task."""
    assert ONE in PACKAGES
    file, diagnostics = read_pipeline(write(PACKAGES.replace(ONE, task), folder))
    assert file is not None, diagnostics
    return file.orders


CHAIN = f"nodes: [{STAGES['pick']}, {STAGES['place']}]\n      edges: [{{src: pick, dst: place}}]"
APART = f"nodes: [{STAGES['pick']}, {STAGES['place']}]"
ALONE = f"nodes: [{STAGES['place'].replace('score: 8', 'score: 10')}]"


@pytest.mark.parametrize(
    ("task", "composition"),
    [(CHAIN, "sequential"), (APART, "parallel"), (ALONE, "atomic")],
    ids=["chain", "apart", "one"],
)
def test_a_graph_that_arena_knows_is_valid_and_comes_back(task: str, composition: str, tmp_path: Path) -> None:
    lowered = orders(task, tmp_path)
    graph = export_environment(lowered, lowered.assemblies[0], "packages")
    jsonschema.validate(graph.document, SCHEMA)
    assert graph.lost == ()
    assert graph.document["task"]["composition"] == composition
    assert [each["id"] for each in graph.document["objects"]] == ["cup", "can"]
    assert graph.document["background"]["params"]["usd_path"] == "packages/table_a/usd/table_a.usda"
    place = graph.document["task"]["subtasks"][-1]
    assert place["kind"] == "PickAndPlaceTask"
    assert (place["params"]["pick_up_object"], place["params"]["destination_location"]) == ("cup", "can")
    again = json.loads(json.dumps(graph.document))
    (before,) = lowered.tasks
    assert import_task(again, before.name, before.model_copy(update={"nodes": ()})) == before


def test_a_graph_that_is_neither_chain_nor_antichain_is_refused_or_loses_its_edges(tmp_path: Path) -> None:
    third = "{id: again, score: 0.001, success: {_func: held_by, object: can}}"
    edges = "[{src: pick, dst: place}, {src: pick, dst: again}]"
    task = f"nodes: [{STAGES['pick']}, {STAGES['place']}, {third}]\n      edges: {edges}"
    lowered = orders(task, tmp_path)
    assert composition_of(lowered.tasks[0].nodes) is None
    with pytest.raises(NotExportable, match="the edge pick -> again"):
        export_environment(lowered, lowered.assemblies[0], "packages")
    graph = export_environment(lowered, lowered.assemblies[0], "packages", lossy=True)
    jsonschema.validate(graph.document, SCHEMA)
    assert set(graph.lost) == {"the edge pick -> again", "the edge pick -> place"}


def test_stages_and_shapes_without_a_counterpart_are_named(tmp_path: Path) -> None:
    file, _ = read_pipeline(write(SOUND, tmp_path))
    assert file is not None
    with pytest.raises(NotExportable) as refused:
        export_environment(file.orders, file.orders.assemblies[0], "packages")
    lines = str(refused.value).splitlines()
    assert "the stage `stand` (upright) has no counterpart in Arena" in lines
    assert "the object `cup`: an inline shape is no package" in lines
    assert "the background: an inline shape or a pool is no package" in lines
    with pytest.raises(NotExportable, match="no stage"):
        export_environment(file.orders, file.orders.assemblies[0], "packages", lossy=True)


def test_a_pool_becomes_a_set_of_objects(tmp_path: Path) -> None:
    pool = "{type: pool, candidates: [{id: cups, assets: [cup_a, cup_b]}]}"
    file, _ = read_pipeline(write(PACKAGES.replace("asset: cup_a", f"asset: {pool}").replace(ONE, ALONE), tmp_path))
    assert file is not None
    graph = export_environment(file.orders, file.orders.assemblies[0], "packages")
    jsonschema.validate(graph.document, SCHEMA)
    (both,) = graph.document["object_sets"]
    assert [member["id"] for member in both["members"]] == ["cup_a", "cup_b"]


def test_the_schema_refuses_what_arena_refuses(tmp_path: Path) -> None:
    lowered = orders(CHAIN, tmp_path)
    document = export_environment(lowered, lowered.assemblies[0], "packages").document
    atomic = json.loads(json.dumps(document))
    atomic["task"]["composition"] = "atomic"
    nested = json.loads(json.dumps(document))
    nested["task"]["subtasks"][0]["subtasks"] = []
    for broken in (atomic, nested):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(broken, SCHEMA)
