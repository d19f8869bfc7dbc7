"""Effects of the library as text: one row for the terminal, one page `docs/reference/effects.md`."""

from __future__ import annotations

from typing import Any

from sim.dynamics.hooks import (
    BodyWrench,
    CommandMap,
    EffortMap,
    Hook,
    JointFriction,
    JointTorque,
    ModelChange,
    SensorMap,
)
from sim.effects.effect import Effect
from sim.effects.library import EFFECTS, RESERVED_NAMES

_ACTS: tuple[tuple[type[Hook], str], ...] = (
    (ModelChange, "changes a number of the model before the first step"),
    (CommandMap, "changes commands and efforts on their way to the drive"),
    (EffortMap, "changes the drive's effort in each step"),
    (JointTorque, "adds a force or torque to the joint in each step"),
    (JointFriction, "adds to the joint's largest friction in each step"),
    (BodyWrench, "adds a force and a torque on the body in each step"),
    (SensorMap, "changes what the sensor reports"),
)

_INTRODUCTION = """# Effects

What `mana gap find` can name: {count} effects. Each has a formula from the literature, parameters in SI units with
bounds (narrowed to what a recording can hold before a search), and a hook that puts it into a simulation step.
`mana gap effects NAME` shows the same in a terminal. An effect that looks like another one names the experiment that
tells them apart. Where the subject of a recording declares a number (friction, mass, gains), a model without the
effect has that number, not the one in the last column.

| effect | formula | parameters |
|---|---|---|
"""


def acts(effect: Effect) -> str:
    """Where in a simulation step the effect acts, in words."""
    return next(words for hook, words in _ACTS if isinstance(effect.hook, hook))


def as_data(effect: Effect) -> dict[str, Any]:
    """Everything about an effect, ready for JSON."""
    return {
        "name": effect.name,
        "family": effect.family,
        "kinds": list(effect.kinds),
        "formula": effect.formula,
        "source": effect.source,
        "reveals": effect.reveals,
        "acts": acts(effect),
        "parameters": [
            {"name": p.name, "unit": p.unit, "low": p.low, "high": p.high, "without_effect": p.null}
            for p in effect.parameters
        ],
        "confusable_with": [{"effect": c.effect, "experiment": c.experiment} for c in effect.confusables],
        "usd": effect.export.usd,
        "urdf": effect.export.urdf,
    }


def page() -> str:
    """The reference page."""
    rows = "".join(
        f"| [{e.name}](#{e.name.replace('.', '')}) | `{_cell(e.formula)}` | "
        f"{', '.join(f'`{p.name}`' for p in e.parameters)} |\n"
        for e in EFFECTS
    )
    reserved = ", ".join(f"`{n}`" for n in sorted(RESERVED_NAMES))
    tail = f"\nReserved names without an effect yet: {reserved}.\n" if reserved else ""
    return _INTRODUCTION.format(count=len(EFFECTS)) + rows + tail + "".join(_section(e) for e in EFFECTS)


def _section(effect: Effect) -> str:
    parameters = "".join(
        f"| `{p.name}` | {_cell(p.unit)} | {p.low:g} to {p.high:g} | {p.null:g} |\n" for p in effect.parameters
    )
    alike = "".join(f"- Looks like `{c.effect}`; to tell: {c.experiment}.\n" for c in effect.confusables)
    files = [f"{kind} `{at}`" if at else "" for kind, at in (("USD", effect.export.usd), ("URDF", effect.export.urdf))]
    carried = ", ".join(f for f in files if f) or "no attribute; `extension.json` carries it"
    return (
        f"\n## {effect.name}\n\n`{effect.formula}` ({effect.source})\n\n"
        f"- In the data: {effect.reveals}.\n- In a step: {acts(effect)}.\n"
        f"- Measurements: {', '.join(effect.kinds)}.\n- In files: {carried}.\n{alike}\n"
        f"| parameter | unit | bounds | without effect |\n|---|---|---|---|\n{parameters}"
    )


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
