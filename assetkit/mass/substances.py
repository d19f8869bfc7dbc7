"""Groups the meshes of an object into substances (material class, density) by names and statements of the source."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from assetkit.mass.component_density import component_density
from assetkit.mass.excluded_materials import excluded_materials
from assetkit.taxonomy.material_classes import UNKNOWN, UNKNOWN_FULL, material_for, materials
from schemas.evidence import Evidence, declared
from schemas.model import Mesh
from schemas.stated_physics import StatedMass

# What the source states is used as it is; files give no tolerance.
# A number that the source states: true within this share, with this confidence.
STATED_TOLERANCE, STATED_CONFIDENCE = 0.1, 0.95
FROM_FILE_NAME = 0.6  # A part that names no material is more likely of the file's than not.


@dataclass(frozen=True)
class Substance:
    """One material throughout, over some of the meshes.

    meshes         which of the object's meshes.
    names          their names.
    material       class in the material table.
    density_kgm3   with bounds.
    may_be_hollow  things of this class are often modelled solid but made with thin walls.
    stated         what the source states about the mass of just these meshes (asset frame, metres), or None.
    """

    meshes: tuple[int, ...]
    names: tuple[str, ...]
    material: Evidence[str]
    density_kgm3: Evidence[float]
    may_be_hollow: bool
    stated: StatedMass | None = None


def uniform(names: Sequence[str], *, full: bool = False) -> Substance:
    """One substance throughout, of the class that most of `names` mention; `full` as in `substance_of`."""
    return substance_of(material_for(names), full=full)


def substance_of(
    material: Evidence[str], *, meshes: Sequence[int] = (), names: Sequence[str] = (), full: bool = False
) -> Substance:
    """A substance of a class, with its density as sure as the class.

    A thick body of unknown material may be hollow; a `full` one (walls, plates, tools) is not.
    """
    unknown = material.value == UNKNOWN
    row = materials()[UNKNOWN_FULL if full and unknown else material.value]
    density = Evidence(
        value=row.density_kgm3,
        source=material.source,
        method=f"material class {row.name}"
        + (excluded_materials(*row.density_bounds_kgm3, full=full) if unknown else ""),
        confidence=material.confidence,
        bounds=row.density_bounds_kgm3,
        inputs=material.inputs,
    )
    return Substance(tuple(meshes), tuple(names), material, density, row.may_be_hollow)


def substances_of(
    meshes: Sequence[Mesh],
    render_materials: Sequence[str],
    whole: Sequence[str],
    stated: Sequence[StatedMass],
    *,
    full: bool = False,
) -> tuple[Substance, ...]:
    """The substances of an object, in the order of their first mesh; `full` as in `substance_of`.

    Meshes go together when the same statement of the source covers them, else when their names point to the same class:
    the name of the render material or of the mesh itself, else those of the `whole` (file). What is mentioned nowhere
    is `unknown`; called a component of machines (`component_density`), it is as dense as these are. When all is
    one class, all names vote on it together.
    """
    names = [_names(mesh, render_materials) for mesh in meshes]
    class_names = _classes(names, whole)
    components = [
        component_density(mesh.name) if kind.value == UNKNOWN else None
        for mesh, kind in zip(meshes, class_names, strict=True)
    ]
    keys = [
        (_statement_of(mesh, stated), kind.value if component is None else component.method)
        for mesh, kind, component in zip(meshes, class_names, components, strict=True)
    ]
    if len(set(keys)) == 1 and keys[0][0] is None and components[0] is None:
        material = material_for([*whole, *(name for mesh_names in names for name in mesh_names)])
        return (substance_of(material, meshes=range(len(meshes)), names=[m.name for m in meshes], full=full),)
    groups: dict[tuple[int | None, str], list[int]] = {}
    for index, (statement, kind) in enumerate(keys):
        # A stated mass is that of all its meshes together, whatever their names.
        together = statement is not None and stated[statement].mass_kg is not None
        groups.setdefault((statement, "" if together else kind), []).append(index)
    substances: list[Substance] = []
    for (statement, kind), members in groups.items():
        material = class_names[members[0]] if kind else material_for([n for i in members for n in names[i]])
        substance = substance_of(material, meshes=members, names=[meshes[i].name for i in members], full=full)
        component = components[members[0]] if kind else None
        if component is not None:
            substance = replace(substance, density_kgm3=component, may_be_hollow=False)
        substances.append(substance if statement is None else _as_stated(substance, stated[statement]))
    return tuple(substances)


def _classes(names: Sequence[Sequence[str]], whole: Sequence[str]) -> list[Evidence[str]]:
    """Per mesh the class that its names mention, else with less confidence that of the whole."""
    general = material_for(whole)
    inherited = general.model_copy(update={"confidence": FROM_FILE_NAME * general.confidence})
    of_meshes = [material_for(mesh_names) for mesh_names in names]
    return [material if material.source != "default" else inherited for material in of_meshes]


def _as_stated(substance: Substance, stated: StatedMass) -> Substance:
    if stated.density is None:
        return replace(substance, stated=stated)
    bounds = ((1.0 - STATED_TOLERANCE) * stated.density, (1.0 + STATED_TOLERANCE) * stated.density)
    density = declared(stated.density, stated.method, inputs=(str(stated.where),)).model_copy(update={"bounds": bounds})
    return replace(substance, density_kgm3=density, may_be_hollow=False)


def _names(mesh: Mesh, render_materials: Sequence[str]) -> tuple[str, ...]:
    return (mesh.name,) if mesh.material is None else (render_materials[mesh.material], mesh.name)


def _statement_of(mesh: Mesh, stated: Sequence[StatedMass]) -> int | None:
    return next((i for i, s in enumerate(stated) if mesh.source_path in s.covers), None)
