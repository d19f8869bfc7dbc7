"""Material class of each part, from names, usual materials of such parts and surface appearance, by Bayes' rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from assetkit.materials.surface_appearance import METALNESSES, ROUGHNESSES, TONES, AppearanceSampler, SurfaceAppearance
from assetkit.taxonomy.category_materials import appearance_table, class_names, household_prior, material_prior
from assetkit.taxonomy.material_classes import UNKNOWN, mentioned_material
from assetkit.taxonomy.words import words_of
from schemas.appearance.material import Material
from schemas.arrays import FloatArray, IntArray
from schemas.evidence import Evidence, default, inferred
from schemas.model import Mesh, Model
from schemas.parts import Part

CONTENTS = "food"  # In the name of a thing that is never made of it, a word for it names the contents.
METALS, METAL = ("steel", "aluminium", "copper"), "metal"
# Probability that a material word is right, without other evidence: in the name of the render material or node, of the
# file, of a folder, which may hold other things.
_OWN_NAME, _FILE_NAME, _FOLDER_NAME = 0.85, 0.8, 0.5
# Exponents of likelihoods: pixels of one surface are not independent, and one colour for all is weaker than a picture.
_PAINTED, _PLAIN, _MAPS = 1.0, 0.5, 0.7
_MIN_LIKELIHOOD_RATIO = 1.2  # least likelihood ratio of a clue that the method names
_LEAST_PROBABILITY = 0.01  # least probability of any appearance, whatever the tables hold
MIN_CHANCE, MIN_CHANCE_BY_APPEARANCE, MIN_LEAD, ONE_METAL = 0.5, 0.65, 1.5, 0.65
_MAX_CONFIDENCE = 0.95


def part_materials(
    meshes: Mapping[str, Mesh],
    model: Model,
    parts: Sequence[Evidence[Part]],
    category: Evidence[str],
    file_name: str,
    folders: Sequence[str] = (),
) -> tuple[tuple[Evidence[Part], ...], Evidence[str]]:
    """`parts` with their materials, and the material of the whole; `meshes` of `model` by id.

    Names of nodes and render materials count for the part, that of the file and its folders for the whole.
    """
    sampler = AppearanceSampler(model)
    everything = [(mesh, np.arange(len(mesh.triangles))) for mesh in meshes.values()]
    names = _render_names([mesh for mesh, _ in everything], model.materials)
    whole = material_of(sampler.of(everything), category, own_names=names, of_whole=(file_name, *folders))
    with_material: list[Evidence[Part]] = []
    for evidence in parts:
        part = evidence.value
        regions = [(meshes[f.mesh], f.indices) for f in part.faces]
        names = (part.name, part.source_path.rpartition("/")[2])
        names += _render_names([mesh for mesh, _ in regions], model.materials)
        label = part.label.value if part.label.confidence > 0.0 else ""
        material = material_of(
            sampler.of(regions), category, label=label, own_names=names, of_whole=(file_name, *folders)
        )
        with_material.append(evidence.model_copy(update={"value": part.model_copy(update={"material": material})}))
    return tuple(with_material), whole


def face_materials(
    meshes: Mapping[str, Mesh], parts: Sequence[Evidence[Part]], whole: Evidence[str]
) -> tuple[tuple[Evidence[str], ...], tuple[IntArray, ...]]:
    """Materials of the visible surface, that of the whole first, and per mesh (m,) which of them each triangle has.

    A triangle is of the smallest part with a known material that holds it, else of the whole. Parts of one class share
    the evidence of the largest.
    """
    materials = [whole]
    of_face = {mesh_id: np.zeros(len(mesh.triangles), dtype=np.int64) for mesh_id, mesh in meshes.items()}
    for part in sorted((p.value for p in parts), key=lambda p: (-p.area_m2, p.part_id)):
        if part.material.value == UNKNOWN:
            continue
        known = [material.value for material in materials]
        if part.material.value not in known:
            materials.append(part.material)
            known.append(part.material.value)
        for faces in part.faces:
            of_face[faces.mesh][faces.indices] = known.index(part.material.value)
    return tuple(materials), tuple(of_face.values())


@dataclass(frozen=True)
class MaterialChances:
    """Probabilities (k,) of the classes `class_names()`, and the factors (k,) of the clues behind them, in words.

    is_usual  whether usual materials of the part or thing are among the clues; is_named  whether a name is.
    """

    chances: FloatArray
    clues: Mapping[str, FloatArray]
    is_usual: bool
    is_named: bool

    def deciding(self, members: Sequence[str]) -> tuple[str, ...]:
        """The clues for the classes `members` together, the strongest first."""
        index = [class_names().index(name) for name in members]
        lifts = {clue: _lift(row, index) for clue, row in self.clues.items()}
        ranked = sorted(lifts, key=lambda clue: (-lifts[clue], clue))
        return tuple(clue for clue in ranked if lifts[clue] > _MIN_LIKELIHOOD_RATIO)


def material_of(
    appearance: SurfaceAppearance,
    category: Evidence[str],
    *,
    label: str = "",
    own_names: Sequence[str] = (),
    of_whole: Sequence[str] = (),
) -> Evidence[str]:
    """The class of a part (`label`) or of a whole thing (""), `unknown` when none is likely or another nearly so.

    `metal` when it is one of several metals. The method names the clues that decided, the strongest first.
    """
    weighed = material_chances(appearance, category, label=label, own_names=own_names, of_whole=of_whole)
    value, chance, rival = _best(weighed.chances)
    known = weighed.is_usual or weighed.is_named
    if chance < (MIN_CHANCE if known else MIN_CHANCE_BY_APPEARANCE) or chance < MIN_LEAD * rival:
        return default(UNKNOWN, "neither names nor looks tell one material")
    method = "; ".join(weighed.deciding(METALS if value == METAL else (value,)))
    return inferred(value, method, min(chance, _MAX_CONFIDENCE))


def material_chances(
    appearance: SurfaceAppearance,
    category: Evidence[str],
    *,
    label: str = "",
    own_names: Sequence[str] = (),
    of_whole: Sequence[str] = (),
    further: Mapping[str, FloatArray] | None = None,
) -> MaterialChances:
    """The probability of each class, by Bayes' rule from the same evidence as `material_of`.

    `further` are factors (k,) of other clues, in words.
    """
    words = tuple(word for name in own_names for word in words_of(name))
    usual, prior_text = material_prior(category.value if category.confidence > 0.0 else "", label, words)
    prior = household_prior()
    if usual is not None:
        known = max(category.confidence, 0.6 if prior_text.startswith("a ") else 0.0)
        prior = known * usual + (1.0 - known) * prior
    clues = {f"usual for {prior_text}": prior / household_prior()} if usual is not None else {}
    filled = usual is not None and usual[class_names().index(CONTENTS)] == 0.0
    samples = ((own_names, _OWN_NAME), (of_whole[:1], _FILE_NAME), (of_whole[1:], _FOLDER_NAME))
    named = next(filter(None, (_name_factors(names, sure, filled=filled) for names, sure in samples)), {})
    clues |= named | _appearance_factors(appearance) | dict(further or {})
    chances = household_prior() * np.prod(list(clues.values()), axis=0) if clues else household_prior()
    return MaterialChances(chances / chances.sum(), clues, usual is not None, bool(named))


def _lift(row: FloatArray, index: Sequence[int]) -> float:
    """Likelihood ratio of the classes `index` by a clue, against the household prior."""
    usual = household_prior()
    return float((row[index] @ usual[index]) / usual[index].sum() / (row @ usual))


def _best(chances: FloatArray) -> tuple[str, float, float]:
    """The likeliest class, its chance and that of the next; metals count together, as `metal` when none leads."""
    table = dict(zip(class_names(), chances, strict=True))
    together = sum(float(table[name]) for name in METALS)
    leading = max(METALS, key=lambda name: table[name])
    ranked = sorted(
        [(together, leading if table[leading] >= ONE_METAL * together else METAL)]
        + [(float(chance), name) for name, chance in table.items() if name not in METALS],
        reverse=True,
    )
    return ranked[0][1], ranked[0][0], ranked[1][0]


def _name_factors(names: Sequence[str], sure: float, *, filled: bool) -> dict[str, FloatArray]:
    """A factor (k,) for the material words in `names`: alone it gives the class the probability `sure`; none for the
    contents of something `filled`.
    """
    mentioned = dict.fromkeys(material for name in names if (material := mentioned_material(name)) is not None)
    if filled:
        mentioned.pop(CONTENTS, None)
    factors = np.ones(len(class_names()))
    for name in mentioned:
        members = [class_names().index(member) for member in (METALS if name == METAL else (name,))]
        usual = household_prior()[members].sum()
        factors[members] = sure / (1.0 - sure) * (1.0 - usual) / usual
    return {f"name says {' and '.join(mentioned)}": factors} if mentioned else {}


def _appearance_factors(appearance: SurfaceAppearance) -> dict[str, FloatArray]:
    """Factors (k,) of each kind of appearance that the surface has."""
    factors: dict[str, FloatArray] = {}
    if appearance.tones is not None:
        power = _PAINTED if appearance.painted else _PLAIN
        factors[f"{_most(appearance.tones, TONES)} colour"] = _likelihood(appearance.tones, TONES) ** power
    if appearance.roughness is not None:
        factors[f"{_most(appearance.roughness, ROUGHNESSES)} surface"] = (
            _likelihood(appearance.roughness, ROUGHNESSES) ** _MAPS
        )
    if appearance.metalness is not None:
        name = _most(appearance.metalness, METALNESSES).replace("_", " ")
        factors[f"{name} in its maps"] = _likelihood(appearance.metalness, METALNESSES)
    if appearance.see_through >= 0.5:
        factors["see-through"] = _column("see_through")
    return factors


def _likelihood(shares: FloatArray, columns: Sequence[str]) -> FloatArray:
    """(k,) the geometric mean of what each class shows of each column, by share of the surface."""
    return np.exp(sum(share * np.log(_column(name)) for share, name in zip(shares, columns, strict=True)))


def _column(name: str) -> FloatArray:
    return np.array([max(row[name], _LEAST_PROBABILITY) for row in appearance_table().values()])


def _most(shares: FloatArray, names: Sequence[str]) -> str:
    return names[int(np.argmax(shares))]


def _render_names(meshes: Sequence[Mesh], materials: Sequence[Material]) -> tuple[str, ...]:
    """Names of the render materials on `meshes`, when all have the same one."""
    used = {mesh.material for mesh in meshes}
    return tuple(materials[k].name for k in used if k is not None) if len(used) == 1 else ()
