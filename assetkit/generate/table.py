"""The generators by name, one row each."""

from __future__ import annotations

from typing import Any

from assetkit.generate.generator import Generator
from assetkit.generate.objects import (
    balance_scale,
    blocks,
    button_panel,
    cabinet,
    charger,
    coloured_basket,
    drawer_unit,
    hanoi_set,
    hinged_box,
    knob_panel,
    light_switch,
    microwave,
    pump_bottle,
    stackable_cup,
    stacking_rings,
    turntable,
)

_ALL: tuple[Generator[Any], ...] = (
    balance_scale.GENERATOR,
    blocks.GENERATOR,
    button_panel.GENERATOR,
    cabinet.GENERATOR,
    charger.GENERATOR,
    coloured_basket.GENERATOR,
    drawer_unit.GENERATOR,
    hanoi_set.GENERATOR,
    hinged_box.GENERATOR,
    knob_panel.GENERATOR,
    light_switch.GENERATOR,
    microwave.GENERATOR,
    pump_bottle.GENERATOR,
    stackable_cup.GENERATOR,
    stacking_rings.GENERATOR,
    turntable.GENERATOR,
)
GENERATORS: dict[str, Generator[Any]] = {generator.name: generator for generator in _ALL}
