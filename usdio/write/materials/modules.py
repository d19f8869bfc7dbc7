"""The MDL modules of a package: variants of the materials of NVIDIA's library, each with all its parameters.

A package may name only files that it holds (SimReady NP.008, AA.001), and a copy of a module of the library would be
another module (VM.MDL.001). A variant is neither: a file of three lines, which imports the material by its name on the
search path of the renderer (MDL specification: variants of materials and functions).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

MODULE_FOLDER: Final = "mdl"
# Material of the library -> file name of its variant; the materials keep their names.
MODULE_FILES: Final = {
    "OmniPBR": "mana_opaque.mdl",
    "OmniGlass": "mana_transmissive.mdl",
    "OmniPBR_ClearCoat": "mana_coated.mdl",
}


def module_sources(names: Iterable[str]) -> dict[str, str]:
    """File name -> source text of the variants of the materials called `names`; other names are passed over."""
    used = sorted(set(names) & set(MODULE_FILES))
    return {MODULE_FILES[name]: _variant(name) for name in used}


def _variant(name: str) -> str:
    return f"mdl 1.6;\nimport ::{name}::{name};\nexport material {name}(*) = ::{name}::{name}();\n"
