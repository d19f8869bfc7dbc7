"""The gate's tables of MaterialX nodes agree with MaterialX's own library, and know every shader that is written."""

from __future__ import annotations

import importlib
from typing import Any

from gate.rules.visual.shader_node import USD_TYPES, shader_inputs
from gate.rules.visual.shader_value import shader_ranges
from usdio.write.materials.modules import MODULE_FILES
from usdio.write.materials.outputs import OUTPUTS


def test_nodes_and_inputs_are_those_of_the_library() -> None:
    mx: Any = importlib.import_module("MaterialX")  # its bindings have no types
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    nodes = {name: inputs for name, inputs in shader_inputs().items() if name.startswith("ND_")}
    assert nodes
    for name, inputs in nodes.items():
        declared = {port.getName(): port.getType() for port in library.getNodeDef(name).getActiveInputs()}
        assert inputs == declared, name


def test_ranges_are_of_inputs_that_exist() -> None:
    for shader, inputs in shader_inputs().items():
        assert set(shader_ranges().get(shader, {})) <= set(inputs), shader


def test_every_mdl_material_that_is_written_is_known() -> None:
    written = {output.name for row in OUTPUTS.values() for output in row if output.context == "mdl"}
    assert written == set(MODULE_FILES)
    assert written <= set(shader_inputs())
    assert {kind for inputs in shader_inputs().values() for kind in inputs.values()} <= set(USD_TYPES)
