"""Source names of a package's prims: mapping from prim path to source name, and the finding on changed names."""

from __future__ import annotations

from collections.abc import Mapping

from schemas.diagnostics import Diagnostic, finding
from schemas.model import Model
from usdio.write.materials.mesh_materials import material_prim_names


def source_names(model: Model) -> dict[str, str]:
    """Prim path below the root (`Visuals/cup`, `Materials/glaze`) -> source name, of every mesh and material."""
    meshes = {f"Visuals/{mesh_id}": mesh.name for mesh_id, mesh in model.meshes_by_id.items()}
    return meshes | {f"Materials/{prim}": name for prim, name in material_prim_names(model).items()}


def rename_findings(names: Mapping[str, str]) -> tuple[Diagnostic, ...]:
    """One `asset/name-sanitised` finding with the number of `source_names` that had to change, or none."""
    changed = [(path, name) for path, name in names.items() if path.rpartition("/")[2] != name]
    if not changed:
        return ()
    path, name = changed[0]
    headline = f"{len(changed)} of {len(names)} names were changed, such as {name!r} to {path!r}"
    return (finding("asset/name-sanitised", headline, value=len(changed), bound=0, unit="names"),)
