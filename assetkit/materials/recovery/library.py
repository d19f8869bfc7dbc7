"""The library of plausible materials: `library.csv` as values, with the class and family of each entry.

Base colours are linear sRGB. `colour_basis` is how the colour is known: `published` in the source named, `measured` as
the mean of its texels, or an `estimate`, which is marked so. Finishes are choices.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from schemas.appearance.material import LinearRGB

METALS: Final = ("steel", "aluminium", "copper")  # classes of `materials.csv` that are one family
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class LibraryMaterial(BaseModel):
    """One entry; `usual` is its weight among the entries of its class, any positive scale."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    material_class: str
    red: Share
    green: Share
    blue: Share
    roughness: Share
    metallic: Share
    ior: float = Field(ge=1.0, le=2.5)
    transmission: Share
    usual: float = Field(gt=0.0)
    colour_basis: Literal["published", "measured", "estimate", "generated"]
    source: str = Field(min_length=1)
    licence: str = Field(min_length=1)

    @property
    def base_color(self) -> LinearRGB:
        """Linear sRGB."""
        return self.red, self.green, self.blue

    @property
    def family(self) -> str:
        """Metal, wood, plastic and so on."""
        return family_of(self.material_class)


def family_of(material_class: str) -> str:
    """The family of a class of `assetkit/taxonomy/materials.csv`: `metal` for all metals, else the class itself."""
    return "metal" if material_class in METALS else material_class


def classes_of(family: str) -> Sequence[str]:
    """The classes of a family."""
    return METALS if family == "metal" else (family,)


@cache
def library() -> tuple[LibraryMaterial, ...]:
    """All entries, in the order of the table."""
    with resources.files("assetkit").joinpath("materials", "recovery", "library.csv").open(encoding="utf-8") as text:
        return tuple(LibraryMaterial.model_validate(row) for row in csv.DictReader(text))
