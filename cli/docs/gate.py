"""The page `docs/reference/gate.md` from the rules of the gate: one row per rule."""

from __future__ import annotations

from cli.docs.diagnostics import file_name
from gate.rules.rule import Rule
from gate.static_gate import RULES

_INTRODUCTION = """# The static gate

`mana assets validate PATH` reads a USD file as a simulator would and asks {count} rules whether what it says can be
true. Nothing is simulated; a package takes a fraction of a second. Outside validators (SimReady Foundation,
`pxr.UsdValidation`) judge form; the gate judges plausibility: a door with inverted limits is well-formed.

- `error`: wrong in any file, or wrong in a package that claims to be SimReady (SimReady metadata, or a `record.json`
  beside the USD folder). Nothing with an error is released.
- `warning`: suspicious.
- `info`: keeps a file that claims nothing from being a package, such as centimetres or y up. No fault of the file.

Lengths, masses and angles are converted by the stage's own `metersPerUnit` and `kilogramsPerUnit` first, so that a file
in centimetres is judged like any other. Instances, nested frames, scaled bodies and bodies without mass (which engines
compute from volume and density) are followed; values of the wrong type count as missing or as NaN.

Each rule is one file in `gate/rules/`. Bounds were set so that packages made of real assets, and files of others that
simulate well, give no error; `benchmarks/gate/seeded_defects.py` measures what is caught.

## Rules

| rule | what it finds | passes | why | source |
|---|---|---|---|---|
"""


def page() -> str:
    """The page as text."""
    return _INTRODUCTION.format(count=len(RULES)) + "".join(map(_row, RULES))


def _row(rule: Rule) -> str:
    code = rule.code
    link = f"[{code.name.removeprefix('asset/gate-')}](../diagnostics/{file_name(code.name)})"
    cells = [link, code.title, rule.bound, code.why, rule.source]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"
