"""What a part is made of: names, what such parts are usually of, and how its surface looks, weighed by Bayes' rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from assetkit.materials.surface_appearance import METALNESSES, ROUGHNESSES, TONES, Look, Looks
from assetkit.taxonomy.material_classes import UNKNOWN, mentioned
from assetkit.taxonomy.usual_materials import classes, household, looks_table, usual_of
from assetkit.taxonomy.words import words_of
from schemas.evidence import Evidence, default, inferred
from schemas.model import FloatArray, IntArray, Material, Mesh, Model
from schemas.parts import Part

CONTENTS = "food"  # A word for it in the name of a thing that is never made of it tells what is in it.
METALS, METAL = ("steel", "aluminium", "copper"), "metal"
# How sure a material word is where nothing else is known: in the name of the render material or node, of the file, of a
# folder, which may hold other things.
_OWN_NAME, _FILE_NAME, _FOLDER_NAME = 0.85, 0.8, 0.5
# Pixels of one surface are not independent witnesses, and one colour for all says less than a picture.
_PAINTED, _PLAIN, _MAPS = 1.0, 0.5, 0.7
_TELLING = 1.2  # times likelier: what makes it less so did not decide
_LEAST = 0.01  # chance of anything, whatever tables say
STANDS, STANDS_BY_LOOKS, RIVAL, ONE_METAL = 0.5, 0.65, 1.5, 0.65
_MOST = 0.95


def part_materials(
    meshes: Mapping[str, Mesh],
    model: Model,
    parts: Sequence[Evidence[Part]],
    category: Evidence[str],
    file_name: str,
    folders: Sequence[str] = (),
) -> tuple[tuple[Evidence[Part], ...], Evidence[str]]:
    """`parts` with their materials, and the material of the whole; `meshes` of `model` by prim name.

    Names of nodes and render materials speak of the part, that of the file and its folders of the whole.
    """
    looks = Looks(model)
    everything = [(mesh, np.arange(len(mesh.triangles))) for mesh in meshes.values()]
    names = _render_names([mesh for mesh, _ in everything], model.materials)
    whole = material_of(looks.of(everything), category, own_names=names, of_whole=(file_name, *folders))
    made: list[Evidence[Part]] = []
    for evidence in parts:
        part = evidence.value
        regions = [(meshes[f.mesh], f.indices) for f in part.faces]
        names = (part.name, part.source_path.rpartition("/")[2])
        names += _render_names([mesh for mesh, _ in regions], model.materials)
        label = part.label.value if part.label.confidence > 0.0 else ""
        material = material_of(
            looks.of(regions), category, label=label, own_names=names, of_whole=(file_name, *folders)
        )
        made.append(evidence.model_copy(update={"value": part.model_copy(update={"material": material})}))
    return tuple(made), whole


def face_materials(
    meshes: Mapping[str, Mesh], parts: Sequence[Evidence[Part]], whole: Evidence[str]
) -> tuple[tuple[Evidence[str], ...], tuple[IntArray, ...]]:
    """Materials of the visible surface, that of the whole first, and per mesh (m,) which of them each triangle has.

    A triangle is of the smallest part with a known material that holds it, else of the whole. Parts of one class share
    the evidence of the largest.
    """
    found = [whole]
    of_face = {prim: np.zeros(len(mesh.triangles), dtype=np.int64) for prim, mesh in meshes.items()}
    for part in sorted((p.value for p in parts), key=lambda p: (-p.area_m2, p.part_id)):
        if part.material.value == UNKNOWN:
            continue
        known = [material.value for material in found]
        if part.material.value not in known:
            found.append(part.material)
            known.append(part.material.value)
        for faces in part.faces:
            of_face[faces.mesh][faces.indices] = known.index(part.material.value)
    return tuple(found), tuple(of_face.values())


def material_of(
    look: Look,
    category: Evidence[str],
    *,
    label: str = "",
    own_names: Sequence[str] = (),
    of_whole: Sequence[str] = (),
) -> Evidence[str]:
    """The class of a part (`label`) or of a whole thing (""), `unknown` when none is likely or another nearly so.

    `metal` when it is one of several metals. The method names what decided, the surest clue first.
    """
    words = tuple(word for name in own_names for word in words_of(name))
    usual, told = usual_of(category.value if category.confidence > 0.0 else "", label, words)
    prior = household()
    if usual is not None:
        known = max(category.confidence, 0.6 if told.startswith("a ") else 0.0)
        prior = known * usual + (1.0 - known) * prior
    clues = {f"usual for {told}": prior / household()} if usual is not None else {}
    filled = usual is not None and usual[classes().index(CONTENTS)] == 0.0
    places = ((own_names, _OWN_NAME), (of_whole[:1], _FILE_NAME), (of_whole[1:], _FOLDER_NAME))
    named = next(filter(None, (_said(names, sure, filled=filled) for names, sure in places)), {})
    clues |= named | _seen(look)
    chances = household() * np.prod(list(clues.values()), axis=0) if clues else household()
    chances = chances / chances.sum()
    value, chance, rival = _best(chances)
    if chance < (STANDS if usual is not None or named else STANDS_BY_LOOKS) or chance < RIVAL * rival:
        return default(UNKNOWN, "neither names nor looks tell one material")
    members = METALS if value == METAL else (value,)
    index = [classes().index(name) for name in members]
    lifts = {clue: _lift(row, index) for clue, row in clues.items()}
    deciding = sorted(lifts, key=lambda clue: (-lifts[clue], clue))
    method = "; ".join(clue for clue in deciding if lifts[clue] > _TELLING)
    return inferred(value, method, min(chance, _MOST))


def _lift(row: FloatArray, index: Sequence[int]) -> float:
    """How many times a clue makes the classes `index` likelier against the household mixture."""
    usual = household()
    return float((row[index] @ usual[index]) / usual[index].sum() / (row @ usual))


def _best(chances: FloatArray) -> tuple[str, float, float]:
    """The likeliest class, its chance and that of the next; metals count together, as `metal` when none leads."""
    table = dict(zip(classes(), chances, strict=True))
    together = sum(float(table[name]) for name in METALS)
    leading = max(METALS, key=lambda name: table[name])
    ranked = sorted(
        [(together, leading if table[leading] >= ONE_METAL * together else METAL)]
        + [(float(chance), name) for name, chance in table.items() if name not in METALS],
        reverse=True,
    )
    return ranked[0][1], ranked[0][0], ranked[1][0]


def _said(names: Sequence[str], sure: float, *, filled: bool) -> dict[str, FloatArray]:
    """A factor (k,) for the material words in `names`: alone it makes the class as likely as `sure`; none for what
    something is `filled` with.
    """
    heard = dict.fromkeys(found for name in names if (found := mentioned(name)) is not None)
    if filled:
        heard.pop(CONTENTS, None)
    factors = np.ones(len(classes()))
    for name in heard:
        members = [classes().index(member) for member in (METALS if name == METAL else (name,))]
        usual = household()[members].sum()
        factors[members] = sure / (1.0 - sure) * (1.0 - usual) / usual
    return {f"name says {' and '.join(heard)}": factors} if heard else {}


def _seen(look: Look) -> dict[str, FloatArray]:
    """Factors (k,) of each kind of appearance that something states."""
    found: dict[str, FloatArray] = {}
    if look.tones is not None:
        power = _PAINTED if look.painted else _PLAIN
        found[f"{_most(look.tones, TONES)} colour"] = _likelihood(look.tones, TONES) ** power
    if look.roughness is not None:
        found[f"{_most(look.roughness, ROUGHNESSES)} surface"] = _likelihood(look.roughness, ROUGHNESSES) ** _MAPS
    if look.metalness is not None:
        name = _most(look.metalness, METALNESSES).replace("_", " ")
        found[f"{name} in its maps"] = _likelihood(look.metalness, METALNESSES)
    if look.see_through >= 0.5:
        found["see-through"] = _column("see_through")
    return found


def _likelihood(shares: FloatArray, columns: Sequence[str]) -> FloatArray:
    """(k,) the geometric mean of what each class shows of each column, by share of the surface."""
    return np.exp(sum(share * np.log(_column(name)) for share, name in zip(shares, columns, strict=True)))


def _column(name: str) -> FloatArray:
    return np.array([max(row[name], _LEAST) for row in looks_table().values()])


def _most(shares: FloatArray, names: Sequence[str]) -> str:
    return names[int(np.argmax(shares))]


def _render_names(meshes: Sequence[Mesh], materials: Sequence[Material]) -> tuple[str, ...]:
    """Names of the render materials on `meshes`, when all have the same one."""
    used = {mesh.material for mesh in meshes}
    return tuple(materials[k].name for k in used if k is not None) if len(used) == 1 else ()
