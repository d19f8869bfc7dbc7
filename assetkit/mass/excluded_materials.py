"""Materials outside the default bounds (kg/m3) of an unknown density, as text for the record."""

from __future__ import annotations

# kg/m3: solid things from above; from below hollow things by mass over volume, and materials that are light throughout.
_SOLID = (("steel", 7850.0), ("aluminium", 2700.0), ("stone", 2400.0), ("water", 1000.0))
_DENSEST = (("brass", 8500.0), ("lead", 11_340.0), ("gold", 19_300.0))
_LIGHT = (("a shell of plastic", 150.0), ("empty packaging", 40.0), ("foam", 20.0))
_LIGHT_FULL = (("cork or balsa", 160.0), ("foam", 100.0))


def excluded_materials(low_kgm3: float, high_kgm3: float, *, full: bool = False) -> str:
    """ "; outside: ..." with the things denser than `high_kgm3` or lighter than `low_kgm3`, "" when none is.

    `full`: the body has no room to be hollow.
    """
    missed = [f"solid {name}" for name, density in (*_DENSEST, *_SOLID) if density > high_kgm3]
    missed += [name for name, density in (_LIGHT_FULL if full else _LIGHT) if density < low_kgm3]
    return f"; outside: {', '.join(missed)}" if missed else ""
