"""How likely each family of materials is for a degraded surface: names, category, part, walls, density, statements.

The probabilities are those of `assetkit.materials.part_materials`, by Bayes' rule from the same tables; colours that
degraded surfaces seem to have are left out. Each further clue is a factor per class with its words.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources

import numpy as np

from assetkit.materials.part_materials import MaterialChances, material_chances
from assetkit.materials.recovery.library import classes_of, family_of
from assetkit.materials.surface_appearance import SurfaceAppearance
from assetkit.taxonomy.category_materials import appearance_table, class_names
from assetkit.taxonomy.material_classes import materials, mentioned_material
from assetkit.taxonomy.words import words_of
from schemas.arrays import FloatArray
from schemas.evidence import Evidence, default, inferred

# Likelihood of walls thinner than the thinnest usual of a class, and of a density outside that of a class: models leave
# out walls and state densities of hollow bodies, so neither excludes a class.
_TOO_THIN, _OTHER_DENSITY = 0.15, 0.1
_STATED_DIELECTRIC = 0.7  # exponent: authors write 0 for metals too, where their tool has no metals
MOST_WITHOUT_NAME, MOST_WITH_NAME = 0.5, 0.9  # confidence without and with the material's word on the surface itself


@dataclass(frozen=True)
class SurfaceClues:
    """What is known of a degraded surface beside its colours.

    label       part name of the category, "" for none.     own_names  of its meshes, material, part and contact.
    of_whole    names of the file and its folders.           appearance of its trustworthy values alone.
    wall_mm     usual thickness of its walls, None where unknown or not thin.   density_kgm3  as stated, or None.
    dielectric  whether a trustworthy value states that it is no metal.
    """

    label: str = ""
    own_names: tuple[str, ...] = ()
    of_whole: tuple[str, ...] = ()
    appearance: SurfaceAppearance = field(default_factory=SurfaceAppearance)
    wall_mm: float | None = None
    density_kgm3: float | None = None
    dielectric: bool = False


@dataclass(frozen=True)
class FamilyChances:
    """Probabilities of classes by name; `named` is the family that a name of the surface itself states, or ""."""

    of_class: Mapping[str, float]
    weighed: MaterialChances
    named: str

    def of_family(self, family: str) -> float:
        """The probability of all classes of a family together."""
        return sum(self.of_class.get(name, 0.0) for name in classes_of(family))

    @property
    def likeliest(self) -> str:
        """The family with the highest probability; ties by name."""
        return max({family_of(name) for name in self.of_class}, key=lambda family: (self.of_family(family), family))

    def evidence(self, family: str) -> Evidence[str]:
        """The family with its calibrated confidence and the clues for it; a default where there is no clue at all."""
        if not self.weighed.clues:
            return default(family, "no evidence: the most usual family of household things")
        most = MOST_WITH_NAME if self.named == family else MOST_WITHOUT_NAME
        method = "; ".join(self.weighed.deciding(classes_of(family))) or "usual for household things"
        return inferred(family, method, round(min(self.of_family(family), most), 3))


def family_chances(clues: SurfaceClues, category: Evidence[str]) -> FamilyChances:
    """The probability of each class of the library for one surface."""
    own_names = tuple(own_words(name, clues.of_whole) for name in clues.own_names)
    weighed = material_chances(
        clues.appearance,
        category,
        label=clues.label,
        own_names=tuple(name for name in own_names if name),
        of_whole=clues.of_whole,
        further=_further(clues),
    )
    mentioned = next(filter(None, map(mentioned_material, own_names)), "")
    of_class = dict(zip(class_names(), (float(chance) for chance in weighed.chances), strict=True))
    return FamilyChances(of_class, weighed, family_of(mentioned))


def own_words(name: str, of_whole: Sequence[str]) -> str:
    """The words of a name that the file name lacks: the handle of a wooden cabinet is not therefore wooden."""
    known = {word for whole in of_whole[:1] for word in words_of(whole)}
    return " ".join(word for word in words_of(name) if word not in known)


def _further(clues: SurfaceClues) -> dict[str, FloatArray]:
    factors: dict[str, FloatArray] = {}
    if clues.wall_mm is not None:
        thin = np.array([_TOO_THIN if clues.wall_mm < thinnest_mm().get(name, 0.0) else 1.0 for name in class_names()])
        if thin.min() < 1.0:
            factors[f"walls of {clues.wall_mm:.2g} mm"] = thin
    if clues.density_kgm3 is not None:
        within = [_holds_density(name, clues.density_kgm3) for name in class_names()]
        if any(within):
            factors[f"density of {clues.density_kgm3:.0f} kg/m3"] = np.where(within, 1.0, _OTHER_DENSITY)
    if clues.dielectric:
        column = np.array([row["dielectric"] for row in appearance_table().values()])
        factors["stated as no metal"] = column**_STATED_DIELECTRIC
    return factors


def _holds_density(material_class: str, density_kgm3: float) -> bool:
    low, high = materials()[material_class].density_bounds_kgm3
    return low <= density_kgm3 <= high


@cache
def thinnest_mm() -> Mapping[str, float]:
    """The thinnest usual wall of classes that have one, in millimetres."""
    file = resources.files("assetkit").joinpath("materials", "recovery", "thinnest_walls.csv")
    with file.open(encoding="utf-8") as text:
        return {row["material_class"]: float(row["thinnest_mm"]) for row in csv.DictReader(text)}
