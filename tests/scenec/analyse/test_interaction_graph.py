"""The interaction graph of problems built by hand."""

from __future__ import annotations

import json
from dataclasses import replace

from benchmarks.scenes.workload import box_body, table, workload
from scenec.analyse.interaction_graph import interaction_graph
from scenec.ir.problem import Problem, Thing
from schemas.scene.geometry import BACKGROUND, Domain, SceneRelation


def pair(*, relation: bool, apart: bool) -> Problem:
    """Two boxes whose ranges lie apart, or meet."""
    problem = workload(2, 0)
    ranges = ((-0.5, -0.4), (0.4, 0.5)) if apart else ((-0.5, 0.1), (0.0, 0.5))
    things = tuple(
        Thing(name, box_body(name, 0.1, 0.1), BACKGROUND, table(), Domain(x_m=span), ("layout", "nodes", name))
        for name, span in zip(("a", "b"), ranges, strict=True)
    )
    relations = (SceneRelation("before", ("a", "b"), (0.0, 1.0), word="front_of"),) if relation else ()
    return replace(problem, things=things, relations=relations)


def test_things_are_solved_together_only_where_their_room_may_meet():
    assert interaction_graph(pair(relation=False, apart=False)).components == (("a", "b"),)
    assert interaction_graph(pair(relation=False, apart=True)).components == (("a",), ("b",))


def test_a_directional_relation_orders_components_and_does_not_merge_them():
    graph = interaction_graph(pair(relation=True, apart=True))
    assert graph.components == (("a",), ("b",))
    assert graph.schedule == (0, 1)
    assert [e.label for e in graph.edges if e.kind == "relation"] == ["front_of"]


def test_owners_come_first_and_contents_are_a_component_of_their_own():
    tray = box_body("tray", 0.3, 0.2, top=True)
    things = (
        Thing("mug", box_body("mug", 0.05, 0.05), "tray", tray.surfaces[0], Domain(), ()),
        Thing("tray", tray, BACKGROUND, table(), Domain(), ()),
    )
    graph = interaction_graph(replace(workload(1, 0), things=things))
    assert graph.components == (("mug",), ("tray",))
    assert graph.schedule == (1, 0)
    assert {(e.source, e.target, e.kind) for e in graph.edges} == {
        (BACKGROUND, "tray", "support"),
        ("tray", "mug", "support"),
    }


def test_dot_and_json_name_every_node_and_edge():
    graph = interaction_graph(workload(10, 0))
    read = json.loads(graph.json())
    assert len(read["nodes"]) == 11
    assert len(read["edges"]) == 10 + 45 + 2
    text = graph.dot()
    assert text.count("->") == len(read["edges"])
    assert '"box3" [label="box3"' in text
